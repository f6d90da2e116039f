// The connection to the server: answers each tick at once, and comes back by itself after it was lost.

const SILENCE = 1500;  // [ms] ticks come every 50 ms: after this the connection counts as lost
const WRONG_TOKEN = 4401;
const TOO_MANY = 4503;

export class Link {
  // answer(): what to say to a tick; onMessage(message); onState("open" | "lost" | "token" | "full")
  constructor(token, { answer, onMessage, onState }) {
    Object.assign(this, { token, answer, onMessage, onState, seen: 0, pause: 500 });
    this.connect();
    setInterval(() => this.watch(), 250);
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.heard = performance.now();
    socket.onopen = () => socket.send(JSON.stringify({ token: this.token }));
    socket.onmessage = (event) => socket === this.socket && this.take(JSON.parse(event.data));
    socket.onclose = (event) => socket === this.socket && this.closed(event.code);
  }

  take(message) {
    this.heard = performance.now();
    if (this.seen === 0) {
      this.pause = 500;
      this.onState("open");
    }
    this.seen = message.n;
    this.send(this.answer());  // first: what is drawn may take its time
    this.onMessage(message);
  }

  // false: there is no connection.
  send(message) {
    if (this.seen === 0 || this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ seen: this.seen, ...message }));
    return true;
  }

  watch() {
    if (this.socket && performance.now() - this.heard > SILENCE) {
      const socket = this.socket;
      this.closed(1006);
      socket.close();
    }
  }

  closed(code) {
    this.socket = null;
    this.seen = 0;
    if (code === WRONG_TOKEN) return this.onState("token");
    this.onState(code === TOO_MANY ? "full" : "lost");
    setTimeout(() => this.connect(), this.pause);
    this.pause = Math.min(2 * this.pause, 4000);
  }
}

// Shows the newest image in `element`. The next one is asked for when this one is shown: a slow connection gets fewer.
export async function showImages(token, element) {
  let number = "0";
  for (;;) {
    try {
      const headers = { Authorization: `Bearer ${token}` };
      const answer = await fetch(`image?after=${number}`, { headers, cache: "no-store" });
      if (answer.status === 200) {
        number = answer.headers.get("X-Frame-Number");
        const url = URL.createObjectURL(await answer.blob());
        element.src = url;
        await element.decode().catch(() => undefined);
        URL.revokeObjectURL(url);
      } else if (answer.status === 401) {
        return;
      }
      if (document.hidden) await new Promise((resolve) => setTimeout(resolve, 1000));
    } catch {
      await new Promise((resolve) => setTimeout(resolve, 1000));
    }
  }
}
