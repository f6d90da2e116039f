// The view from above. The dock is up, or on the right where the view is wide, and the chair comes from the other side;
// without a known dock the chair is in the middle.

const MARGIN = 0.35;  // [m] round what is shown
const SMALLEST = 2.0;  // [m] across the view
const WIDE = 1.2;  // width over height
const EASE = 0.25;  // of the way to the wanted section, per view

export class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.section = null;  // middle across and down, width, height [m] on the screen's axes
    this.last = null;
    new ResizeObserver(() => this.last && this.draw(this.last)).observe(canvas);
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => this.last && this.draw(this.last));
  }

  draw(scene) {
    this.last = scene;
    const { canvas } = this;
    const ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const wide = width > WIDE * height;
    this.turn = wide ? ([x, y]) => [x, -y] : ([x, y]) => [-y, -x];  // from the scene to the screen, in metres
    this.aim(scene, wide);
    const [cx, cy, w, h] = this.section;
    this.scale = Math.min(width / w, height / h);
    this.to = (point) => {
      const [across, down] = this.turn(point);
      return [width / 2 + (across - cx) * this.scale, height / 2 + (down - cy) * this.scale];
    };
    const pen = this.pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.lineJoin = pen.lineCap = "round";
    const style = getComputedStyle(canvas);
    this.colour = (name) => style.getPropertyValue(`--${name}`).trim();
    this.content(scene);
    this.ruler(width, height);
  }

  content(scene) {
    for (const outline of scene.bay || []) this.polygon(outline, { fill: "wall" });
    if (scene.docked) this.polygon(scene.docked, { line: "muted", dash: [6, 6] });
    for (const outline of scene.obstacles || []) this.polygon(outline, { fill: "obstacle", alpha: 0.75 });
    for (const point of scene.points || []) this.dot(point, "obstacle", 2);
    for (const { pose, weight } of scene.candidates || []) this.axis(pose, weight);
    for (const plate of scene.plates || []) this.line(plate.ends, "text", 5);
    for (const marker of scene.markers || []) {
      this.ellipse(marker.at, marker.axes, "seen");
      this.dot(marker.at, "seen", 4);
    }
    this.polygon(scene.chair, { fill: "chair", alpha: 0.3, line: "chair" });
    this.line([scene.chair[3], scene.chair[0]], "chair", 5);  // its front
    this.axis(scene.pose, 1, "chair");
    if (scene.path) this.line([scene.pose, ...scene.path], "path", 3);
  }

  // Moves the section shown towards what there is to see.
  aim(scene, wide) {
    const points = [...scene.chair, ...(scene.docked || []), ...(scene.bay || []).flat()];
    for (const outline of scene.obstacles || []) points.push(...outline);
    const near = points.filter(([x, y]) => Math.hypot(x - scene.pose[0], y - scene.pose[1]) < 8);
    const turned = near.map(this.turn), across = turned.map(([u]) => u), down = turned.map(([, v]) => v);
    const span = (values) => [Math.min(...values) - MARGIN, Math.max(...values) + MARGIN];
    const [left, right] = span(across), [top, bottom] = span(down);
    const wanted = [(left + right) / 2, (top + bottom) / 2,
      Math.max(right - left, SMALLEST), Math.max(bottom - top, SMALLEST)];
    const kind = `${scene.frame} ${wide}`;
    this.section = this.kind === kind ? this.section.map((value, i) => value + EASE * (wanted[i] - value)) : wanted;
    this.kind = kind;
  }

  path(points, closed) {
    this.pen.beginPath();
    points.forEach((point, i) => this.pen[i ? "lineTo" : "moveTo"](...this.to(point)));
    if (closed) this.pen.closePath();
  }

  polygon(points, { fill, line, alpha = 1, dash = [] }) {
    const { pen } = this;
    this.path(points, true);
    if (fill) {
      pen.globalAlpha = alpha;
      pen.fillStyle = this.colour(fill);
      pen.fill();
      pen.globalAlpha = 1;
    }
    if (line) {
      pen.strokeStyle = this.colour(line);
      pen.lineWidth = 2;
      pen.setLineDash(dash);
      pen.stroke();
      pen.setLineDash([]);
    }
  }

  line(points, colour, width) {
    this.path(points, false);
    this.pen.strokeStyle = this.colour(colour);
    this.pen.lineWidth = width;
    this.pen.stroke();
  }

  dot(point, colour, radius) {
    this.pen.beginPath();
    this.pen.arc(...this.to(point), radius, 0, 2 * Math.PI);
    this.pen.fillStyle = this.colour(colour);
    this.pen.fill();
  }

  ellipse(at, [large, small, direction], colour) {
    const { pen, scale } = this;
    pen.beginPath();
    const [across, down] = this.turn([Math.cos(direction), Math.sin(direction)]);
    pen.ellipse(...this.to(at), Math.max(large * scale, 1), Math.max(small * scale, 1), Math.atan2(down, across),
      0, 2 * Math.PI);
    pen.strokeStyle = this.colour(colour);
    pen.lineWidth = 2;
    pen.stroke();
  }

  // A short arrow without a head, along x of a pose: a dock's candidate, the chair's heading.
  axis([x, y, heading], weight, colour = "accent") {
    this.pen.globalAlpha = Math.max(0.15, weight);
    this.line([[x, y], [x + 0.35 * Math.cos(heading), y + 0.35 * Math.sin(heading)]], colour, 3);
    this.dot([x, y], colour, 4);
    this.pen.globalAlpha = 1;
  }

  ruler(width, height) {
    const { pen, scale } = this;
    const right = width - 12, bottom = height - 12;
    pen.strokeStyle = pen.fillStyle = this.colour("muted");
    pen.lineWidth = 3;
    pen.beginPath();
    pen.moveTo(right - scale, bottom);
    pen.lineTo(right, bottom);
    pen.stroke();
    pen.font = "14px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.fillText("1 m", right, bottom - 7);
  }
}
