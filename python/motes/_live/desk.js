// The desk: a view whose runs can be started again, with a bar of time over the frames that have been computed.

const AHEAD = 8, MOST_BLOBS = 400, MOST_ASKED = 12, COPIED_MS = 1500;
const TIME = `
  <div class="bar"><canvas data-part="spans" height="6"></canvas>
    <input type="range" data-part="scrub" min="0" max="1" value="0" aria-label="Frame"></div>
  <div class="transport">
    <button data-part="play" aria-label="Play the film">Play</button>
    <button data-part="live" aria-pressed="true">Live</button>
    <output data-part="at"></output>
    <span class="loops">
      <button data-part="from" aria-label="Loop from here" title="Loop from here">[</button>
      <button data-part="loop" aria-pressed="false">Loop</button>
      <button data-part="to" aria-label="Loop to here" title="Loop to here">]</button>
    </span>
  </div>`;
const MORE = `
  <details class="section" data-part="camera"><summary>Camera</summary>
    <form data-part="pose"></form>
    <input type="text" data-part="line" readonly aria-label="The camera as Python">
    <button data-part="copy">Copy as Python</button>
  </details>
  <details class="section" data-part="board"><summary>Blackboard</summary></details>
  <label class="check"><input type="checkbox" data-part="reloads"> Reload the script when it is saved</label>`;
const POSE = { position: "position", look_at: "look at", up: "up", fov_deg: "field of view" };

class Desk extends View {
  constructor(root, say, options) {
    super(root, say, options);
    this.at = null;              // the frame of the film that is shown; null: the run's newest picture
    this.playing = null;         // since when (ms) and from which frame the film plays
    this.loop = null;            // the first and last frame to loop
    this.blobs = new Map();      // "take:frame" -> picture, oldest first
    this.asked = new Set();
    this.unanswered = [];        // numbers of pictures that are not acknowledged while the film is shown
    this.kept = null;            // the newest of them
    this.part("time").innerHTML = TIME;
    this.part("more").innerHTML = MORE;
    const buttons = this.root.querySelector(".buttons");
    for (const [name, text] of [["restart", "Restart"], ["reload", "Reload"], ["save", "Save picture"], ["full", "Full screen"]]) {
      const button = Object.assign(document.createElement("button"), { textContent: text });
      button.dataset.part = name;
      buttons.append(button);
    }
    for (const name of ["pause", "step", "restart", "reload", "reset", "undo", "save", "full", "pace", "stop"]) buttons.append(this.part(name));
    this.makePose();
    this.board = new Blackboard(this, this.part("board"));
    this.listenToDesk();
    new ResizeObserver(() => this.drawSpans()).observe(this.part("spans"));
    this.show();
  }

  keyTable() {
    const key = (shown, says, act) => ({ shown, says, act });
    return { ...super.keyTable(),
             ",": key(", .", "frame back, on", () => this.seek(this.shown() - 1)), ".": key("", "", () => this.seek(this.shown() + 1)),
             "[": key("[ ]", "loop from, to here", () => this.bound(0)), "]": key("", "", () => this.bound(1)),
             o: key("O", "loop", () => this.toggleLoop()), l: key("L", "live", () => this.live()),
             Home: key("Home", "first frame", () => this.seek(0)), End: key("End", "last frame", () => this.seek(this.last())),
             n: key("N", "restart", () => this.restart()), p: key("P", "save the picture", () => this.save()),
             x: key("X", "full screen", () => this.full()) };
  }

  listenToDesk() {
    const on = (name, act) => { this.part(name).onclick = act; };
    on("play", () => this.toggle());
    on("live", () => this.live());
    on("loop", () => this.toggleLoop());
    on("from", () => this.bound(0));
    on("to", () => this.bound(1));
    on("restart", () => this.say({ restart: true }));
    on("reload", () => this.say({ reload: true }));
    on("save", () => this.save());
    on("full", () => this.full());
    on("copy", () => this.copy());
    this.part("notice").title = "Click to close";
    on("notice", () => { if (this.state.error) this.say({ dismiss: true }); });
    this.part("scrub").oninput = event => { this.playing = null; this.seek(Number(event.target.value)); };
    this.part("scrub").onchange = () => this.canvas.focus({ preventScroll: true });
    this.part("reloads").onchange = event => { this.say({ reloads: event.target.checked }); this.focus(event.target); };
  }

  // --- the film

  first() { return this.spans.length ? this.spans[0][0] : 0; }
  last() { return this.spans.length ? this.spans[this.spans.length - 1][1] : 0; }
  shown() { return this.at ?? Number(this.canvas.dataset.frame ?? this.last()); }
  get spans() { return this.state.spans || []; }
  take(frame) { return (this.spans.find(([first, last]) => first <= frame && frame <= last) || [])[2]; }

  // Shows a frame of the film: the nearest one that has a picture.
  seek(frame) {
    if (!this.spans.length) return;
    const inside = this.spans.map(([first, last]) => Math.max(first, Math.min(frame, last)));
    this.at = inside.reduce((best, one) => Math.abs(one - frame) < Math.abs(best - frame) ? one : best);
    const file = this.blobs.get(`${this.take(this.at)}:${this.at}`);
    if (file) this.paint(this.at, file); else this.ask(this.at);
    this.showTime();
  }

  ask(frame) {
    if (this.asked.size >= MOST_ASKED) this.asked.clear();  // the answers are lost, or late
    if (this.asked.has(frame)) return;
    this.asked.add(frame);
    this.say({ seek: frame });
  }

  paint(frame, file) {
    this.draw(file, { frame, number: 0, exact: false }, () => this.at === frame);
  }

  toggle() {
    if (this.playing) { this.playing = null; this.showTime(); return; }
    if (!this.spans.length) return;
    const [first, last] = this.range(), from = this.at === null || this.at >= last || this.at < first ? first : this.at;
    this.playing = { since: performance.now(), from };
    requestAnimationFrame(() => this.playOn());
  }

  // The first and last frame to play; an open end follows the run.
  range() {
    const [first, last] = this.loop || [null, null];
    return [first ?? this.first(), last ?? this.last()];
  }

  playOn() {
    if (!this.playing) return;
    const [first, last] = this.range(), dt = (this.state.dt || 1 / 24) * 1000;
    let frame = this.playing.from + Math.floor((performance.now() - this.playing.since) / dt);
    if (frame > last) {
      if (this.looping) {
        this.playing = { since: performance.now(), from: first };
        frame = first;
      } else {
        this.playing = null;
        frame = last;
      }
    }
    if (frame !== this.at) this.seek(frame);
    for (let next = frame + 1; next <= Math.min(frame + AHEAD, last); next++) {
      if (!this.blobs.has(`${this.take(next)}:${next}`) && this.asked.size < MOST_ASKED) this.ask(next);
    }
    requestAnimationFrame(() => this.playOn());
  }

  toggleLoop() {
    this.looping = !this.looping;
    this.loop = null;
    if (this.looping && !this.playing) this.toggle();
    this.showTime();
  }

  bound(end) {
    const now = this.shown(), [first, last] = this.loop || [null, null];
    this.loop = end ? [first !== null && first < now ? first : null, now] : [now, last !== null && last > now ? last : null];
    this.looping = true;
    this.showTime();
  }

  // Returns to the run's newest picture.
  live() {
    this.at = this.playing = null;
    if (this.kept) { const kept = this.kept; this.kept = null; super.pictured(kept); }
    for (const number of this.unanswered.splice(0)) this.say({ ack: number });
    this.showTime();
  }

  pictured(message) {
    const number = message.getUint32(4, true), frame = message.getUint32(8, true), kind = message.getUint32(16, true);
    if (kind === 2) {
      const bytes = new Uint8Array(message.buffer, message.byteOffset + 20, message.byteLength - 20);
      const file = new Blob([bytes], { type: "image/jpeg" });
      this.asked.delete(frame);
      this.blobs.set(`${number}:${frame}`, file);
      if (this.blobs.size > MOST_BLOBS) this.blobs.delete(this.blobs.keys().next().value);
      if (frame === this.at) this.paint(frame, file);
    } else if (this.at !== null) {
      this.kept = message;
      this.unanswered.push(number);
    } else {
      super.pictured(message);
    }
  }

  drawn() { this.board.drawDomains(); }

  heard(said) {
    if ("board" in said) { this.board.heard(said.board); return; }
    const take = this.state.take;
    if ("refused" in said) this.asked.clear();
    super.heard(said);
    if (take !== undefined && said.take !== undefined && said.take !== take) { this.past = []; this.live(); }
  }

  online(is, trouble) { this.asked?.clear(); super.online(is, trouble); if (is) this.board.online(); }
  orbit(...by) { this.live(); super.orbit(...by); }
  pan(...by) { this.live(); super.pan(...by); }
  zoom(by) { this.live(); super.zoom(by); }
  pause() { if (this.at !== null || this.state.finished) this.toggle(); else super.pause(); }
  step() { if (this.at !== null) this.seek(this.at + 1); else super.step(); }

  restart() { if (this.state.finished || confirm("Start again at frame 0?")) this.say({ restart: true }); }

  // --- what is shown

  show() {
    super.show();
    if (!this.blobs) return;  // the constructor of View shows before there is a desk
    const { state } = this, desk = Boolean(state.desk), over = state.job === "ended" || state.job === "failed";
    const starting = state.job === "starting";
    this.part("time").hidden = !desk;
    for (const name of ["restart", "reload"]) this.part(name).hidden = !desk;
    this.part("restart").disabled = this.part("reload").disabled = !this.isOnline || starting || Boolean(state.ended);
    this.part("reloads").parentElement.hidden = this.part("board").hidden = !desk;
    this.part("reloads").checked = Boolean(state.reloads);
    this.part("save").disabled = !this.file;
    if (state.finished && desk) {
      this.part("stop").textContent = "Finish";
      const frame = this.part("frame").textContent;
      this.part("frames").append(over ? state.job === "failed" ? ", failed" : ", ended" : ", complete");
      if (frame === "-") this.part("frames").textContent = "no frame";
    }
    if (over || starting) for (const name of ["pause", "step", "pace", "stop", "reset", "undo"]) this.part(name).disabled = true;
    this.showPose();
    this.showTime();
    if (this.board.root.open) this.board.show();
  }

  showTime() {
    const { state } = this, last = Math.max((state.total || 0) - 1, this.last(), 1), now = this.shown();
    const scrub = this.part("scrub");
    Object.assign(scrub, { max: last, disabled: !this.spans.length });
    scrub.value = now;
    this.part("play").textContent = this.playing ? "Pause" : "Play";
    this.part("play").disabled = this.part("loop").disabled = !this.spans.length;
    this.part("live").setAttribute("aria-pressed", this.at === null);
    this.part("loop").setAttribute("aria-pressed", Boolean(this.looping));
    const [from, to] = this.range();
    this.part("loop").textContent = this.loop ? `Loop ${from} – ${this.loop[1] === null ? "end" : to}` : "Loop";
    this.part("at").textContent = `${this.at === null ? "live" : "film"} ${now}  ·  ${((now + 1) * (state.dt || 0)).toFixed(2)} s`;
    this.scale = last;
    this.drawSpans();
  }

  drawSpans() {
    const canvas = this.part("spans"), width = canvas.clientWidth || 1, scale = (this.scale || 1) + 1;
    if (canvas.width !== width) canvas.width = width;
    const context = canvas.getContext("2d"), x = frame => frame / scale * width;
    const bar = (first, last, fill) => {
      context.fillStyle = fill;
      context.fillRect(x(first), 0, Math.max(x(last + 1) - x(first), 1), canvas.height);
    };
    context.clearRect(0, 0, width, canvas.height);
    bar(0, scale, "#22262d");
    for (const [first, last, take] of this.spans) bar(first, last, take === this.state.take ? "#3f79b8" : "#3d4654");
    if (this.loop) bar(...this.range(), "#6fb3ff77");
  }

  // --- the camera

  makePose() {
    const form = this.part("pose");
    this.poses = {};
    for (const [name, text] of Object.entries(POSE)) {
      const row = form.appendChild(made("div", "triple")), count = name === "fov_deg" ? 1 : 3;
      row.append(Object.assign(document.createElement("span"), { textContent: text }));
      this.poses[name] = Array.from({ length: count }, (_, i) => {
        const input = Object.assign(document.createElement("input"), { type: "number", step: "any" });
        input.setAttribute("aria-label", count > 1 ? `${text} ${"xyz"[i]}` : `${text}, degrees`);
        input.onchange = () => this.setPose();
        return row.appendChild(input);
      });
    }
    form.onsubmit = event => event.preventDefault();
  }

  setPose() {
    const camera = {};
    for (const [name, inputs] of Object.entries(this.poses)) {
      const numbers = inputs.map(input => input.valueAsNumber);
      if (numbers.some(Number.isNaN)) return;
      camera[name] = name === "fov_deg" ? numbers[0] : numbers;
    }
    this.live();
    this.turning();
    this.say({ camera });
  }

  showPose() {
    const camera = this.state.camera;
    this.part("camera").hidden = !camera;
    if (!camera) return;
    const inputs = Object.values(this.poses).flat(), held = inputs.includes(this.part("pose").getRootNode().activeElement);
    const off = !this.isOnline || Boolean(this.state.repeats) || ["ended", "failed"].includes(this.state.job);
    for (const [name, row] of Object.entries(this.poses)) {
      const numbers = [camera[name]].flat();
      row.forEach((input, i) => { input.disabled = off; if (!held) input.value = +numbers[i].toPrecision(7); });
    }
    const triple = name => `(${camera[name].join(", ")})`;
    this.part("line").value = `motes.Camera(${triple("position")}, ${triple("look_at")}, up=${triple("up")}, fov_deg=${camera.fov_deg})`;
  }

  copy() {
    const line = this.part("line"), button = this.part("copy");
    line.select();
    const written = navigator.clipboard ? navigator.clipboard.writeText(line.value) : Promise.reject();
    written.catch(() => document.execCommand("copy")).then(() => {
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy as Python"; }, COPIED_MS);
    });
  }

  // --- the picture

  save() {
    if (!this.file) return;
    const link = document.createElement("a"), type = this.file.type === "image/png" ? "png" : "jpg";
    const name = (this.state.title || "motes").replace(/\.py$/, "");
    link.href = URL.createObjectURL(this.file);
    link.download = `${name}-${String(this.canvas.dataset.frame).padStart(4, "0")}.${type}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  full() {
    if (document.fullscreenElement) document.exitFullscreen(); else this.root.requestFullscreen();
  }
}
