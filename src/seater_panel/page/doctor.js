// What the doctor says of the installation, in the place of the pictures: Stop stays where it is.
const MARKS = { ok: "✔", wrong: "✘", "not judged": "–" };
const ORDER = ["wrong", "not judged", "ok"];

export class Doctor {
  constructor(token, { open, close, again, text, list, section }) {
    Object.assign(this, { token, again, text, list, section, runs: false, driving: false });
    open.onclick = () => {
      section.hidden = !section.hidden;
      if (!section.hidden && !list.children.length) this.ask();
    };
    close.onclick = () => { section.hidden = true; };
    again.onclick = () => this.ask();
  }

  // Whether a goal runs: the doctor looks at a chair that stands.
  drives(active) {
    this.driving = active;
    this.again.disabled = active || this.runs;
  }

  async ask() {
    if (this.runs) return;
    this.runs = this.again.disabled = true;
    this.text.textContent = "Looking … the chair stands, the joystick is let go.";
    this.list.replaceChildren();
    try {
      const headers = { Authorization: `Bearer ${this.token}` };
      const answer = await fetch("doctor", { method: "POST", headers, cache: "no-store" });
      this.show(answer.ok ? await answer.json() : { error: await answer.text() });
    } catch {
      this.show({ error: "no connection" });
    }
    this.runs = false;
    this.again.disabled = this.driving;
  }

  show({ error, checks = [] }) {
    const wrong = checks.filter((check) => check.result === "wrong").length;
    this.text.textContent = error || (wrong ? `${wrong} of ${checks.length} checks see a fault` : "No fault is seen");
    const sorted = [...checks].sort((a, b) => ORDER.indexOf(a.result) - ORDER.indexOf(b.result));
    this.list.replaceChildren(...sorted.map((check) => {
      const line = document.createElement("li");
      line.className = check.result === "wrong" ? "bad" : check.result === "ok" ? "good" : "muted";
      const name = document.createElement("b");
      name.textContent = `${MARKS[check.result] || "?"} ${check.name}`;
      line.append(name, ` ${check.what}`);
      if (check.remedy) {
        const remedy = document.createElement("p");
        remedy.textContent = `→ ${check.remedy}`;
        line.append(remedy);
      }
      return line;
    }));
  }
}
