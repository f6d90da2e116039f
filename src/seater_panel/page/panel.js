// Puts what the server says on the page.
import { Buttons } from "./buttons.js";
import { Doctor } from "./doctor.js";
import { Link, showImages } from "./link.js";
import { Scene } from "./scene.js";

const $ = (id) => document.getElementById(id);
const GATE = {
  STOPPED: ["stands", ""], REQUEST: ["drives", "good"], USER: ["joystick", "warn"], STALE: ["braking", "warn"],
  REFUSED: ["braking", "bad"], EMERGENCY_STOP: ["emergency stop", "bad"], FAULT: ["fault", "bad"],
  RUNAWAY: ["motors off", "bad"], WRONG_DIRECTION: ["motors off", "bad"], OBSTACLE: ["obstacle", "warn"],
};
const LINK = {
  open: ["connected", "good"], lost: ["no connection", "bad"], token: ["wrong token", "bad"],
  none: ["no token", "bad"], full: ["too many pages", "bad"],
};

// The token comes behind the # of the address, which is sent nowhere; it is kept for a reload of this tab.
function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return given || sessionStorage.getItem("token");
}

function badge(id, [text, kind]) {
  put(id, text);
  $(id).className = `badge ${kind}`;
}

// Only what changes: a screen reader says it once.
function put(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

function notice(text) {
  put("notice", text);
  $("notice").hidden = !text;
}

const known = (value, digits, unit) => value === null ? "–" : `${value.toFixed(digits)} ${unit}`;

function show(view) {
  put("dock", view.dock);
  offer(view.docks, view.dock);
  const begins = buttons.granted && !view.active;  // the docking node has not answered yet
  put("title", begins ? "Starting" : view.title);
  put("reason", begins ? "" : view.reason);
  const [, kind] = GATE[view.gate] || ["", "bad"];
  const result = view.result;
  const ended = !view.active && !begins && result && kind !== "bad" ? (result.success ? "good" : "warn") : "";
  $("state").className = kind === "bad" || kind === "warn" ? kind : ended;
  badge("gate", GATE[view.gate] || ["gate silent", "bad"]);
  put("distance", known(view.distance, 2, "m"));
  put("speed", known(view.speed === null ? null : Math.abs(view.speed), 2, "m/s"));
  put("elapsed", known(view.elapsed, 0, "s"));
  put("result", result && !view.active && !begins ? lastResult(result) : "");
  $("no-image").hidden = view.image;
  put("frame", view.scene.frame === "dock" ? "" : "the dock has not been seen yet");
  scene.draw(view.scene);
  doctor.drives(Boolean(view.active));
}

// A list to choose from, where there are several docks; it keeps the choice, and begins with the dock in use.
function offer(docks, inUse) {
  const list = $("docks"), several = docks.length > 1;
  list.hidden = !several;
  $("dock").hidden = several;
  const shown = [...list.options].map((option) => option.value);
  if (docks.join("\n") === shown.join("\n")) return;
  const chosen = docks.includes(list.value) ? list.value : inUse;
  list.replaceChildren(...docks.map((name) => new Option(name, name, false, name === chosen)));
}

function lastResult({ action, code, name, error, age }) {
  const off = error ? ` · ${error.distance.toFixed(1)} mm, ${Math.abs(error.heading).toFixed(2)}° off` : "";
  const ago = age < 60 ? `${Math.round(age)} s` : `${Math.round(age / 60)} min`;
  return `Last ${action}: ${name} (${code})${off} · ${ago} ago`;
}

function linkState(state) {
  document.body.dataset.link = state;
  badge("link", LINK[state]);
  if (state === "open") return;
  buttons.lost();
  badge("gate", ["–", ""]);  // what was said last may be true no longer
  $("state").className = "bad";
  const refused = state === "token" || state === "none";
  put("title", refused ? "No access" : "No connection");
  put("reason", refused
    ? "Open the address with the token that the terminal shows."
    : "The chair drives only while a connected button is held.");
}

const token = takeToken();
const scene = new Scene($("scene"));
const doctor = new Doctor(token, {
  open: $("doctor-button"), close: $("doctor-close"), again: $("doctor-again"), text: $("doctor-text"),
  list: $("doctor-list"), section: $("doctor"),
});
let link = null;
const buttons = new Buttons([...document.querySelectorAll("button.hold")], $("stop"), {
  send: (message) => Boolean(link && link.send(message)), notice,
  dock: () => $("docks").hidden ? "" : $("docks").value,
});

function onMessage({ view, hold }) {
  document.body.classList.toggle("view-only", !hold.buttons);
  buttons.take(hold);
  if (view) show(view);
}

if (token) {
  link = new Link(token, { answer: () => buttons.answer(), onMessage, onState: linkState });
  showImages(token, $("image"));
} else {
  linkState("none");
}
