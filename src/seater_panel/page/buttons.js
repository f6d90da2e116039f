// Hold-to-run: a button counts as held only while a finger (or Space, Enter) is on it, this page is in front and the
// server says so, too. Whatever ends that ends the press; only lifting the finger and pressing again begins a new one.

export class Buttons {
  // send(message): false when there is no connection; notice(text); dock(): the chosen dock, empty: the configured one
  constructor(buttons, stop, { send, notice, dock = () => "" }) {
    Object.assign(this, { buttons, send, notice, dock, press: 0, held: null, granted: false, ready: false, taken: false });
    for (const button of buttons) this.wire(button);
    stop.addEventListener("pointerdown", () => this.stop());
    stop.addEventListener("keydown", (event) => [" ", "Enter"].includes(event.key) && this.stop());
    addEventListener("keydown", (event) => event.key === "Escape" && this.stop());
    addEventListener("blur", () => this.release());
    addEventListener("pagehide", () => this.release());
    addEventListener("contextmenu", (event) => event.preventDefault());
    document.addEventListener("visibilitychange", () => document.hidden && this.release());
    this.draw();
  }

  wire(button) {
    button.addEventListener("pointerdown", (event) => {
      if (!event.isPrimary || event.button !== 0) return;
      button.setPointerCapture(event.pointerId);
      this.begin(button);
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(name, () => this.release());
    }
    button.addEventListener("pointermove", (event) => {  // the finger slides off
      const box = button.getBoundingClientRect();
      const inside = event.clientX >= box.left && event.clientX <= box.right
        && event.clientY >= box.top && event.clientY <= box.bottom;
      if (!inside) this.release();
    });
    button.addEventListener("keydown", (event) => {
      if (![" ", "Enter"].includes(event.key)) return;
      event.preventDefault();
      if (!event.repeat) this.begin(button);
    });
    button.addEventListener("keyup", (event) => [" ", "Enter"].includes(event.key) && this.release());
    button.addEventListener("blur", () => this.release());
  }

  begin(button) {
    if (this.held || button.disabled) return;
    this.press += 1;
    if (!this.send({ press: this.press, action: button.dataset.action, dock: this.dock() })) {
      this.notice("No connection: nothing was sent.");
      return;
    }
    this.notice("");
    this.held = button;
    this.granted = false;
    this.draw();
  }

  release() {
    if (!this.held) return;
    this.drop();
    this.send({ release: this.press });
  }

  stop() {
    this.drop();
    if (this.send({ stop: true })) this.notice("");
    else this.notice("No connection: Stop was not sent. The chair stops by itself when the button is silent.");
  }

  // What to say to a tick.
  answer() {
    return this.held ? { held: this.press } : {};
  }

  // The server's view of the hold.
  take(hold) {
    const taken = hold.holder === "somebody";
    if (!this.ready || taken !== this.taken) {
      Object.assign(this, { ready: true, taken });
      this.draw();
    }
    if (!this.held || hold.press !== this.press) return;
    const mine = hold.holder === "you";
    if (mine === this.granted && mine) return;
    if (!mine) {
      const over = this.granted && !hold.ended;  // the goal has ended; its result says how
      this.drop();
      if (!over) this.notice(`${sentence(hold.refused || hold.ended)} Let go, then press again.`);
      return;
    }
    this.granted = true;
    if (navigator.vibrate) navigator.vibrate(30);
    this.draw();
  }

  // The connection is lost.
  lost() {
    if (this.held) this.notice("Connection lost: the chair is stopped. Let go, then press again.");
    this.ready = false;
    this.drop();
  }

  drop() {
    this.held = null;
    this.granted = false;
    this.draw();
  }

  draw() {
    for (const button of this.buttons) {
      const held = button === this.held;
      button.classList.toggle("held", held && this.granted);
      button.classList.toggle("asking", held && !this.granted);
      button.disabled = this.taken || !this.ready;
      const text = this.taken ? "somebody else" : held && this.granted ? "let go to stop" : "hold to drive";
      button.querySelector("small").textContent = text;
    }
  }
}

function sentence(text) {
  return text ? `${text[0].toUpperCase()}${text.slice(1)}.` : "";
}
