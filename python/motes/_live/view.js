// The view of a run: its picture, buttons and controls. The live page and the notebook's widget provide the connection:
// `say(order)` sends a viewer's order; `heard(state)` and `pictured(message)` receive states and pictures.

const HALF_TURN = Math.PI, REFUSED_MS = 4000, RATE_MS = 500, MOST_TIMES = 30, MOST_UNDONE = 100, GESTURE_MS = 700;
const PARTS = `
  <main>
    <canvas data-part="picture" width="16" height="9" tabindex="0"
            aria-label="The animation. Drag or use the arrow keys to orbit."></canvas>
    <p data-part="blank" hidden>This run makes no pictures.</p>
    <div data-part="notice" role="status" hidden></div>
  </main>
  <div data-part="time" hidden></div>
  <aside>
    <h1 data-part="title">motes</h1>
    <p class="facts"><span data-part="frames">no frame yet</span><br><span data-part="rate"></span></p>
    <div class="buttons">
      <button data-part="pause" disabled>Pause</button>
      <button data-part="step" disabled>Step</button>
      <button data-part="reset" disabled>Reset view</button>
      <button data-part="undo" disabled>Undo</button>
      <button data-part="pace" aria-pressed="false" disabled>At film speed</button>
      <button data-part="stop" disabled>End run</button>
    </div>
    <div data-part="controls"></div>
    <div data-part="more"></div>
    <details class="help"><summary>Mouse and keys</summary><p>Drag: orbit. Right button or Shift: move. Wheel: zoom.
      Two fingers: move and zoom.</p><dl data-part="keys"></dl></details>
  </aside>
  <pre data-part="output" tabindex="0" aria-label="Output" hidden></pre>`;

class View {
  // `keys`: the element that receives key events. `embedded`: the view is part of another page; it uses the wheel only
  // while the picture has the focus, and may not show dialogs.
  constructor(root, say, { keys = root, embedded = false } = {}) {
    this.root = root;
    this.say = say;
    this.embedded = embedded;
    this.state = {};
    this.isOnline = true;
    this.trouble = "";           // message about the connection
    this.refusal = "";
    this.times = [];             // when the last pictures arrived (ms)
    this.decoding = Promise.resolve();
    this.rows = new Map();       // name of a control -> its row in the page
    this.wishes = {};            // values that have not been sent yet
    this.moves = { orbit: [0, 0], pan: [0, 0], zoom: 0 };
    this.due = false;
    this.fingers = new Map();
    this.past = [];              // orders that undo what was done, newest last
    this.gesture = { name: "", at: 0 };
    this.keysHeld = this.keyTable();
    root.classList.add("motes-view");
    root.innerHTML = PARTS;
    this.canvas = this.part("picture");
    this.part("keys").replaceChildren(...Object.values(this.keysHeld).filter(key => key.says).flatMap(({ shown, says }) =>
      [Object.assign(document.createElement("dt"), { textContent: shown }),
       Object.assign(document.createElement("dd"), { textContent: says })]));
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.listenToButtons();
    this.listenToPointer();
    this.onKey = event => this.pressed(event);
    keys.addEventListener("keydown", this.onKey);
    this.keys = keys;
    this.timer = setInterval(() => this.showRate(), RATE_MS);
    this.show();
    this.showRate();  // now, so that the page does not shift half a second later
  }

  part(name) { return this.root.querySelector(`[data-part=${name}]`); }

  close() {
    clearInterval(this.timer);
    this.keys.removeEventListener("keydown", this.onKey);
  }

  // --- messages from the run

  online(is, trouble = "") {
    this.isOnline = is;
    this.trouble = trouble;
    this.show();
  }

  heard(said) {
    if ("refused" in said) {
      this.refusal = said.refused;
      clearTimeout(this.refusalTimer);
      this.refusalTimer = setTimeout(() => { this.refusal = ""; this.show(); }, REFUSED_MS);
    } else {
      this.state = said;
    }
    this.show();
  }

  // Shows a picture: a header of 20 bytes, then JPEG or PNG. Pictures are decoded one after the other.
  pictured(message) {
    const number = message.getUint32(4, true), frame = message.getUint32(8, true), exact = message.getUint32(16, true) === 1;
    const bytes = new Uint8Array(message.buffer, message.byteOffset + 20, message.byteLength - 20);
    const file = new Blob([bytes], { type: exact ? "image/png" : "image/jpeg" });
    this.decoding = this.draw(file, { number, frame, exact }).then(() => {
      if (!exact) this.times.push(performance.now());
      if (this.times.length > MOST_TIMES) this.times.shift();
    }).then(() => this.say({ ack: number }));
  }

  // Decodes a file after those before it, and shows it, unless `wanted` says that it came too late.
  draw(file, facts, wanted = () => true) {
    return this.decoding.then(() => createImageBitmap(file)).then(bitmap => {
      if (wanted()) {
        this.resize(bitmap.width, bitmap.height);
        this.context.drawImage(bitmap, 0, 0);
        Object.assign(this.canvas.dataset, facts);
        this.file = file;
        this.drawn();
      }
      bitmap.close();
    }).catch(() => this.heard({ refused: "a picture could not be read" }));
  }

  drawn() {}

  resize(width, height) {
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
  }

  // --- what is shown beside the picture

  show() {
    const { state, canvas } = this, here = this.isOnline && !state.ended, on = here && !state.finished;
    const notice = this.refusal || state.error || this.trouble || state.notice || (state.ended ? "the run has ended" : "");
    this.part("notice").textContent = notice;
    this.part("notice").hidden = !notice;
    this.part("notice").classList.toggle("error", Boolean(this.refusal || state.error));
    this.part("title").textContent = state.title || "motes";
    canvas.hidden = state.width === 0;
    this.part("blank").hidden = !canvas.hidden;
    if (state.width && !canvas.dataset.number) this.resize(state.width, state.height);
    const of = state.total ? ` of ${state.total}` : "", paused = state.paused && !state.ended ? ", paused" : "";
    const frame = Object.assign(document.createElement("b"), { textContent: state.frame ?? "-" });
    frame.dataset.part = "frame";
    this.part("frames").replaceChildren("frame ", frame, of + paused);
    this.part("pause").textContent = state.paused ? "Continue" : "Pause";
    for (const name of ["pause", "step", "pace"]) this.part(name).disabled = !on;
    this.part("pace").setAttribute("aria-pressed", Boolean(state.paced));
    for (const name of ["reset", "undo", "stop"]) this.part(name).disabled = !here || Boolean(state.repeats);
    this.part("reset").disabled ||= !state.turned;
    this.part("undo").disabled ||= !this.past.length;
    this.part("stop").disabled ||= Boolean(state.stopping);
    this.part("stop").textContent = state.stop || "End run";
    for (const [name, control] of Object.entries(state.controls || {})) this.showControl(name, control, here && !state.repeats);
    for (const [name, row] of this.rows) row.label.hidden = !(name in (state.controls || {}));
    this.showOutput(state.output || []);
  }

  showOutput(lines) {
    const output = this.part("output"), text = lines.join("\n");
    output.hidden = !text;
    if (output.textContent === text) return;
    output.textContent = text;
    output.scrollTop = output.scrollHeight;
  }

  showRate() {
    const now = performance.now(), recent = this.times.filter(t => now - t < 2000), { state } = this;
    const fps = recent.length > 1 ? (recent.length - 1) / (recent[recent.length - 1] - recent[0]) * 1000 : 0;
    const viewers = state.viewers > 1 ? `, ${state.viewers} viewers` : "";
    const rate = state.paused || state.ended || state.finished ? "no new pictures" : `${fps.toFixed(0)} pictures per second`;
    this.part("rate").textContent = rate + viewers;
  }

  showControl(name, control, on) {
    const kind = JSON.stringify({ ...control, value: typeof control.value });
    let row = this.rows.get(name);
    if (!row || row.kind !== kind) {
      const made = { ...this.makeControl(name, control), kind };
      if (row) row.label.replaceWith(made.label); else this.group(control.group).append(made.label);
      this.rows.set(name, row = made);
    }
    for (const input of row.label.querySelectorAll("input, select")) input.disabled = !on;
    if (!row.input.moving) row.put(control.value);
  }

  group(name) {
    const groups = this.part("controls");
    if (!name) return groups.querySelector(":scope > .alone") || groups.insertBefore(made("div", "alone"), groups.firstChild);
    const found = [...groups.querySelectorAll("details")].find(one => one.dataset.group === name);
    if (found) return found;
    const group = groups.appendChild(made("details", "section"));
    group.open = true;
    group.dataset.group = name;
    group.append(Object.assign(document.createElement("summary"), { textContent: name }));
    return group;
  }

  makeControl(name, control) {
    const label = made("label", "control"), head = made("span", "name");
    head.append(Object.assign(document.createElement("span"), { textContent: name }));
    const wish = value => {
      this.undoable(`set ${name}`, () => ({ set: { [name]: this.state.controls[name].value } }));
      this.wishes[name] = value;
      this.later();
    };
    const row = control.choices ? choice(control, wish) : typeof control.value === "boolean" ? checkBox(wish)
      : typeof control.value === "string" ? colour(wish) : slider(control, name, wish);
    row.input.setAttribute("aria-label", name);
    row.input.dataset.control = name;
    // After a click the picture gets the focus back, and so the keys; keyboard users keep the focus here.
    row.input.addEventListener("pointerup", () => {
      if (row.input.type === "range" || row.input.type === "checkbox") this.focus(row.input);
    });
    row.input.addEventListener("change", () => { if (row.input.type === "select-one") this.focus(row.input); });
    if (row.input.type !== "range") head.append(row.input);
    label.append(head);
    if (row.typed) head.append(row.typed);
    if (row.input.type === "range") label.append(row.input);
    return { ...row, label };
  }

  focus(input) { if (this.canvas.hidden) input.blur(); else this.canvas.focus({ preventScroll: true }); }

  // Notes how to undo what comes next; events of one gesture count as one.
  undoable(name, order) {
    const now = performance.now(), same = name === this.gesture.name && now - this.gesture.at < GESTURE_MS;
    this.gesture = { name, at: now };
    if (same) return;
    this.past.push(order());
    if (this.past.length > MOST_UNDONE) this.past.shift();
    this.part("undo").disabled = false;
  }

  undo() {
    const order = this.past.pop();
    this.gesture.name = "";
    if (order) this.say(order);
    this.show();
  }

  turning() {
    const { turned, camera } = this.state;
    this.undoable("camera", () => ({ camera: turned && camera ? camera : null }));
  }

  // --- orders: mouse moves are summed up and sent once per animation frame

  later() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => this.sendAll());
  }

  sendAll() {
    this.due = false;
    for (const kind of ["orbit", "pan"]) {
      if (this.moves[kind][0] || this.moves[kind][1]) this.say({ [kind]: this.moves[kind] });
      this.moves[kind] = [0, 0];
    }
    if (this.moves.zoom) this.say({ zoom: this.moves.zoom });
    this.moves.zoom = 0;
    const set = this.wishes;
    this.wishes = {};
    if (Object.keys(set).length) this.say({ set });
  }

  orbit(right, up) { this.turning(); this.moves.orbit[0] += right; this.moves.orbit[1] += up; this.later(); }
  pan(right, up) { this.turning(); this.moves.pan[0] += right; this.moves.pan[1] += up; this.later(); }
  zoom(closer) { this.turning(); this.moves.zoom += closer; this.later(); }
  pause() { this.say({ pause: !this.state.paused }); }
  step() { this.say({ step: 1 }); }
  pace() { this.say({ pace: !this.state.paced }); }
  reset() {
    if (this.state.turned) this.undoable("reset", () => ({ camera: this.state.camera }));
    this.say({ camera: null });
  }

  listenToButtons() {
    this.part("pause").onclick = () => this.pause();
    this.part("step").onclick = () => this.step();
    this.part("pace").onclick = () => this.pace();
    this.part("reset").onclick = () => this.reset();
    this.part("undo").onclick = () => this.undo();
    // A button that was clicked gives the keys back to the picture.
    this.root.addEventListener("click", event => {
      const button = event.target.closest("button, summary");
      if (button && event.detail > 0) this.focus(button);
    });
    this.part("stop").onclick = () => {
      if (this.embedded || this.state.finished || confirm("End the run after this frame? Film and log stay complete.")) this.say({ stop: true });
    };
  }

  listenToPointer() {
    const { canvas, fingers } = this;
    canvas.onpointerdown = event => {
      canvas.setPointerCapture(event.pointerId);
      canvas.focus();
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      canvas.classList.add("turning");
      event.preventDefault();
    };
    canvas.onpointermove = event => this.dragged(event);
    canvas.onpointerup = canvas.onpointercancel = event => {
      fingers.delete(event.pointerId);
      if (!fingers.size) canvas.classList.remove("turning");
    };
    canvas.oncontextmenu = event => event.preventDefault();
    canvas.addEventListener("wheel", event => {
      if (this.embedded && canvas.getRootNode().activeElement !== canvas) return;
      const lines = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
      this.zoom(-Math.max(-100, Math.min(100, lines)) * 0.0015);
      event.preventDefault();
    }, { passive: false });
  }

  dragged(event) {
    const before = this.fingers.get(event.pointerId), { clientWidth, clientHeight, width, height: rows } = this.canvas;
    const height = Math.min(clientHeight, clientWidth * rows / width);  // of the picture within the canvas
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const dx = (now.x - before.x) / height, dy = (now.y - before.y) / height;
    if (this.fingers.size === 2) {
      const [other] = [...this.fingers.entries()].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const far = at => Math.hypot(at.x - other.x, at.y - other.y) + 1;
      this.zoom(Math.log(far(now) / far(before)));
      this.pan(-dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) {
      this.pan(-dx, dy);
    } else {
      this.orbit(-dx * HALF_TURN, dy * HALF_TURN);
    }
    this.fingers.set(event.pointerId, now);
  }

  keyTable() {
    const turn = 0.08, key = (shown, says, act) => ({ shown, says, act });
    return {
      " ": key("Space", "pause, continue", () => this.pause()), s: key("S", "one frame", () => this.step()),
      r: key("R", "reset the view", () => this.reset()), u: key("U", "undo", () => this.undo()),
      f: key("F", "film speed", () => this.pace()),
      ArrowLeft: key("Arrows", "orbit", () => this.orbit(-turn, 0)), ArrowRight: key("", "", () => this.orbit(turn, 0)),
      ArrowUp: key("", "", () => this.orbit(0, turn)), ArrowDown: key("", "", () => this.orbit(0, -turn)),
      "+": key("+ -", "zoom", () => this.zoom(0.1)), "-": key("", "", () => this.zoom(-0.1)),
    };
  }

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.composedPath()[0];
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!this.keysHeld[key] || isKeyOf(target, key)) return;
    this.keysHeld[key].act();
    event.preventDefault();
    event.stopPropagation();
  }
}

// Whether the focused element itself uses a key.
function isKeyOf({ tagName, type, readOnly }, key) {
  if (tagName === "SELECT") return key === " " || key.length > 1;
  if (tagName === "BUTTON" || tagName === "SUMMARY" || type === "checkbox" || type === "color") return key === " ";
  if (type === "number") return key.length > 1 || "+-.,".includes(key);
  if (tagName === "PRE") return key === "ArrowUp" || key === "ArrowDown";
  return tagName === "TEXTAREA" || (type === "text" && !readOnly) || (tagName === "INPUT" && key.startsWith("Arrow"));
}

function made(tag, kind) { return Object.assign(document.createElement(tag), { className: kind }); }

// --- inputs of controls: each returns an element and a function that sets its value

function choice(control, wish) {
  const input = document.createElement("select");
  control.choices.forEach((one, i) => input.add(new Option(String(one), i)));
  input.onchange = () => wish(control.choices[input.value]);
  return { input, put: value => { input.value = control.choices.indexOf(value); } };
}

function checkBox(wish) {
  const input = Object.assign(document.createElement("input"), { type: "checkbox" });
  input.onchange = () => wish(input.checked);
  return { input, put: value => { input.checked = value; } };
}

function colour(wish) {
  const input = Object.assign(document.createElement("input"), { type: "color" });
  input.oninput = () => wish(input.value);
  return { input, put: value => { input.value = value; } };
}

function slider(control, name, wish) {
  const { low: min, high: max, step } = control, shown = value => String(+Number(value).toPrecision(5));
  const input = Object.assign(document.createElement("input"), { type: "range", min, max, step: step ?? "any" });
  const typed = Object.assign(document.createElement("input"), { type: "number", min, max, step: step ?? "any" });
  typed.setAttribute("aria-label", `${name}, as a number`);
  typed.dataset.typed = name;
  input.oninput = () => {
    input.moving = true;  // ignore the run's older values until it is released
    typed.value = shown(input.value);
    wish(Number(input.value));
  };
  input.onchange = () => { input.moving = false; };
  typed.onchange = () => {
    const value = typed.valueAsNumber;
    if (!Number.isNaN(value)) wish(Math.min(Math.max(value, min), max));
  };
  const put = value => {
    input.value = value;
    if (typed.getRootNode().activeElement !== typed) typed.value = shown(value);
  };
  return { input, typed, put };
}
