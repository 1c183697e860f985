// The blackboard: who has how much to do, who waits for whom, and the balancer and speeds, which may be changed.

const COLOURS = ["#6fb3ff", "#ffb454", "#7fd88f", "#f07c8b", "#c39bff", "#5fd7d1", "#e8d36a", "#ff9fd0"];
const BOARD = `
  <p class="missing" hidden>The blackboard reads the run's log, which this run does not have: <code>World(log="out/log")</code>.</p>
  <div data-part="figures">
    <p data-part="sentence" class="sentence"></p>
    <label class="check plain"><input type="checkbox" data-part="domains"> Domains over the picture</label>
    <h2>Load <small data-part="load"></small></h2><div data-part="bars" class="bars"></div>
    <h2>Waits <small>seconds; row waits for column</small></h2><table data-part="waits"></table>
    <h2>Imbalance <small data-part="imbalance"></small></h2><canvas data-part="course0" class="course"></canvas>
    <h2>Efficiency <small data-part="efficiency"></small></h2><canvas data-part="course1" class="course"></canvas>
    <h2>Sent in a frame <small data-part="bytes"></small></h2><canvas data-part="course2" class="course"></canvas>
  </div>
  <h2>Balancer</h2>
  <form data-part="balancing"><select data-part="kind" aria-label="Balancer"></select><div data-part="options"></div>
    <button data-part="apply">Use this balancer</button></form>
  <p data-part="balancer" class="sentence"></p>
  <h2>Speeds <small>1: as it is; less: like a slower machine</small></h2>
  <div data-part="speeds"></div>
  <h2>Ranks <small>the run goes on from a checkpoint</small></h2>
  <form data-part="sizing"><input type="number" data-part="size" min="1" step="1" required aria-label="Number of ranks">
    <button data-part="resize">Go on with these ranks</button></form>`;

class Blackboard {
  // `desk`: the view; `root`: a details element whose opening shows the board.
  constructor(desk, root) {
    this.desk = desk;
    this.root = root;
    this.told = {};
    root.insertAdjacentHTML("beforeend", BOARD);
    root.addEventListener("toggle", () => { this.desk.say({ board: root.open }); this.show(); });
    this.overlay = desk.root.querySelector("main").appendChild(made("canvas", "overlay"));
    this.overlay.setAttribute("aria-hidden", "true");
    this.part("domains").onchange = event => { desk.focus(event.target); this.drawDomains(); };
    this.part("kind").onchange = () => this.showOptions({});
    this.part("sizing").onsubmit = event => { event.preventDefault(); this.resize(); };
    this.part("balancing").onsubmit = event => { event.preventDefault(); this.apply(); };
  }

  part(name) { return this.root.querySelector(`[data-part=${name}]`); }
  get state() { return this.desk.state; }
  online() { if (this.root.open) this.desk.say({ board: true }); }
  heard(told) { this.told = told; this.show(); }
  color(rank) { return COLOURS[rank % COLOURS.length]; }

  show() {
    const { told, state } = this;
    if (!this.root.open) { this.drawDomains(); return; }
    this.root.querySelector(".missing").hidden = !told.missing;
    this.part("figures").hidden = Boolean(told.missing) || told.frame === undefined || told.frame === null;
    if (!this.part("figures").hidden) this.showFigures(told);
    this.drawDomains();
    if (state.balancers && state.balancer !== this.shownBalancer) this.showBalancer();
    this.showSpeeds();
    this.showSize();
  }

  showFigures(told) {
    this.part("sentence").textContent = told.sentence || "The run is explained when processors have time for it.";
    const most = Math.max(...told.ranks.map(one => one.t_compute_s), 1e-9);
    this.part("load").textContent = `ms in frame ${told.frame}`;
    this.part("bars").replaceChildren(...told.ranks.map(({ rank, t_compute_s: seconds, particles }) => {
      const row = made("div", "load"), bar = made("i", "");
      bar.style.width = `${100 * seconds / most}%`;
      bar.style.background = this.color(rank);
      const track = made("span", "track");
      track.append(bar);
      row.append(text("span", rank), track, text("span", (seconds * 1000).toFixed(seconds < 0.01 ? 2 : 1)),
                 text("span", particles.toLocaleString("en")));
      row.title = `rank ${rank}: ${(seconds * 1000).toFixed(2)} ms, ${particles} particles`;
      return row;
    }));
    this.showWaits(told.waits);
    this.part("imbalance").textContent = (told.imbalance ?? 1).toFixed(2);
    const efficiency = told.efficiency.parallel;
    this.part("efficiency").textContent = efficiency === null || efficiency === undefined ? "" : `${(100 * efficiency).toFixed(0)} %`;
    this.part("bytes").textContent = shortBytes(told.bytes);
    const [low, high] = [[1, 0, 0], [2, 1, 1]];
    for (const i of [0, 1, 2]) this.drawCourse(this.part(`course${i}`), told.course.map(point => [point[0], point[i + 1]]), low[i], high[i]);
  }

  showWaits(waits) {
    const ranks = [...Array(this.state.ranks || 0).keys()], table = this.part("waits");
    const most = Math.max(...waits.map(one => one[2]), 1e-9), of = new Map(waits.map(([a, b, s]) => [`${a}:${b}`, s]));
    const head = document.createElement("tr");
    head.append(text("th", ""), ...ranks.map(rank => text("th", rank)));
    table.replaceChildren(head, ...ranks.map(rank => {
      const row = document.createElement("tr");
      row.append(text("th", rank), ...ranks.map(other => {
        const seconds = of.get(`${rank}:${other}`) || 0, cell = text("td", seconds ? short(seconds) : rank === other ? "" : "·");
        Object.assign(cell.dataset, { waits: `${rank}:${other}`, seconds });
        cell.style.background = seconds ? `rgb(111 179 255 / ${(0.06 + 0.5 * seconds / most).toFixed(3)})` : "";
        return cell;
      }));
      return row;
    }));
  }

  // Draws a curve over frames; the scale grows beyond `low` and `high` if the curve does.
  drawCourse(canvas, points, low, high) {
    const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1, ratio = devicePixelRatio || 1;
    Object.assign(canvas, { width: width * ratio, height: height * ratio });
    const known = points.filter(([, value]) => value !== null), context = canvas.getContext("2d");
    if (known.length < 2) return;
    context.scale(ratio, ratio);
    const values = known.map(point => point[1]), top = Math.max(high, ...values), first = known[0][0], span = known[known.length - 1][0] - first || 1;
    context.beginPath();
    for (const [frame, value] of known) {
      context.lineTo((frame - first) / span * (width - 2) + 1, height - 2 - (value - low) / (top - low || 1) * (height - 4));
    }
    context.strokeStyle = "#6fb3ff";
    context.lineWidth = 1.5;
    context.stroke();
  }

  // --- balancer and speeds

  showBalancer() {
    const { balancers, balancer } = this.state, kind = this.part("kind"), name = balancer.split("(")[0];
    this.shownBalancer = balancer;
    kind.replaceChildren(...Object.keys(balancers).map(one => new Option(one, one)));
    if (name in balancers) kind.value = name;
    this.part("balancer").textContent = `Now: ${balancer}`;
    const given = {};
    for (const [, option, value] of balancer.matchAll(/(\w+)=("[^"]*"|'[^']*'|[^,)]+)/g)) given[option] = value.replace(/['"]/g, "");
    this.showOptions(given);
  }

  showOptions(given) {
    const options = (this.state.balancers || {})[this.part("kind").value] || [];
    this.part("options").replaceChildren(...options.map(([name, kind, value, most]) => {
      const label = made("label", "name"), now = name in given ? given[name] : String(value);
      let input;
      if (kind === "over") {
        input = document.createElement("select");
        for (const one of ["system", "all"]) input.add(new Option(one, one));
        input.value = now;
      } else if (kind === "flag") {
        input = Object.assign(document.createElement("input"), { type: "checkbox", checked: now === "true" || now === "True" });
      } else {
        input = Object.assign(document.createElement("input"), { type: "number", min: 0, max: most ?? "", step: kind === "count" ? 1 : "any", value: now });
      }
      Object.assign(input.dataset, { option: name, kind });
      label.append(text("span", name.replace(/_/g, " ")), input);
      return label;
    }));
  }

  apply() {
    const given = [...this.part("options").querySelectorAll("[data-option]")].map(input => {
      const { option, kind } = input.dataset;
      const value = kind === "over" ? `"${input.value}"` : kind === "flag" ? (input.checked ? "True" : "False") : input.value;
      return value === "" ? "" : `${option}=${value}`;
    });
    this.desk.say({ balancer: `${this.part("kind").value}(${given.filter(Boolean).join(", ")})` });
    this.desk.focus(this.part("apply"));
  }

  resize() {
    this.desk.say({ resize: this.part("size").valueAsNumber });
    this.desk.focus(this.part("resize"));
  }

  showSize() {
    const { ranks, job } = this.state, size = this.part("size");
    this.part("resize").disabled = job !== "running" || !this.desk.isOnline;
    if (ranks !== this.shownRanks) size.value = this.shownRanks = ranks;
  }

  showSpeeds() {
    const { speeds = {}, calculators = [] } = this.state, root = this.part("speeds");
    if (root.children.length !== calculators.length) {
      root.replaceChildren(...calculators.map(rank => {
        const row = slider({ low: 0.05, high: 1, step: 0.05 }, `speed of rank ${rank}`, speed => this.desk.say({ speeds: { [rank]: speed } }));
        const label = made("label", "control"), head = made("span", "name");
        row.input.dataset.speed = rank;
        row.input.setAttribute("aria-label", `Speed of rank ${rank}`);
        row.input.addEventListener("pointerup", () => this.desk.focus(row.input));
        head.append(text("span", `rank ${rank}`), row.typed);
        label.append(head, row.input);
        label.put = row.put;
        return label;
      }));
    }
    calculators.forEach((rank, i) => {
      const label = root.children[i];
      if (!label.querySelector("input[type=range]").moving) label.put(speeds[rank] ?? 1);
    });
  }

  // --- domains over the picture

  drawDomains() {
    const canvas = this.overlay, picture = this.desk.canvas, { camera, axes } = this.state;
    const shows = this.root.open && this.part("domains").checked && camera && this.told.domains && this.desk.at === null;
    canvas.hidden = !shows;
    if (!shows) return;
    const ratio = devicePixelRatio || 1, { clientWidth: width, clientHeight: height } = picture;
    Object.assign(canvas, { width: width * ratio, height: height * ratio });
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px`, left: `${picture.offsetLeft}px`, top: `${picture.offsetTop}px` });
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    const scale = Math.min(width / picture.width, height / picture.height) * picture.height / 2;
    const seen = projection(camera, width / 2, height / 2, scale, picture.width / picture.height);
    const [first] = Object.keys(axes || {});
    for (const [system, rank, ...ends] of this.told.domains) {
      if (system !== first || /hilbert|morton/.test(axes[system]) || !/^[xyz]+$/.test(axes[system])) continue;
      const cut = { [axes[system][0]]: ends.slice(0, 2), ...(axes[system].includes("y") && axes[system][0] !== "y" ? { y: ends.slice(2, 4) } : {}),
                    ...(axes[system].includes("z") && axes[system][0] !== "z" ? { z: ends.slice(4, 6) } : {}) };
      const box = [..."xyz"].map((axis, i) => {
        const [low, high] = cut[axis] || [null, null], middle = camera.look_at[i], reach = seen.reach[i];
        return [low ?? Math.min(middle - reach, (high ?? middle) - 0.2 * reach), high ?? Math.max(middle + reach, (low ?? middle) + 0.2 * reach)];
      });
      this.drawBox(context, seen, box, rank);
    }
  }

  drawBox(context, seen, box, rank) {
    context.strokeStyle = context.fillStyle = this.color(rank);
    context.lineWidth = 1.25;
    const corner = bits => [0, 1, 2].map(axis => box[axis][bits >> axis & 1]);
    context.beginPath();
    for (let bits = 0; bits < 8; bits++) {
      for (const axis of [0, 1, 2]) {
        if (bits >> axis & 1) continue;
        const line = seen.line(corner(bits), corner(bits | 1 << axis));
        if (line) { context.moveTo(...line[0]); context.lineTo(...line[1]); }
      }
    }
    context.stroke();
    const label = seen.point(box.map(([low, high], i) => i === 1 ? high : (low + high) / 2));
    if (label) {
      context.font = "600 12px system-ui, sans-serif";
      context.textAlign = "center";
      context.fillText(`rank ${rank}`, label[0], label[1] - 6);
    }
  }
}

function text(tag, content) { return Object.assign(document.createElement(tag), { textContent: content }); }
function short(seconds) { return seconds >= 100 ? seconds.toFixed(0) : seconds >= 1 ? seconds.toFixed(1) : seconds.toFixed(2); }
function shortBytes(bytes) { return bytes >= 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : `${(bytes / 1e3).toFixed(1)} kB`; }

// Returns how points (m) come onto the picture, px; `scale`: half the picture's height, px.
function projection({ position, look_at: target, up, fov_deg: fov }, x, y, scale, aspect) {
  const minus = (a, b) => a.map((one, i) => one - b[i]), dot = (a, b) => a.reduce((sum, one, i) => sum + one * b[i], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = a => a.map(one => one / Math.hypot(...a));
  const forward = unit(minus(target, position)), right = unit(cross(forward, up)), above = cross(right, forward);
  const far = Math.hypot(...minus(target, position)), tangent = Math.tan(fov * Math.PI / 360), near = far / 100;
  const place = point => { const arm = minus(point, position); return [dot(arm, right), dot(arm, above), dot(arm, forward)]; };
  const flat = ([across, high, deep]) => [x + across / deep / tangent * scale, y - high / deep / tangent * scale];
  const line = (from, to) => {
    let [a, b] = [place(from), place(to)];
    if (a[2] < near && b[2] < near) return null;
    const cut = (inside, outside) => inside.map((one, i) => one + (outside[i] - one) * (inside[2] - near) / (inside[2] - outside[2]));
    if (a[2] < near) a = cut(b, a); else if (b[2] < near) b = cut(a, b);
    return [flat(a), flat(b)];
  };
  const point = one => { const seen = place(one); return seen[2] < near ? null : flat(seen); };
  // How far along each axis domains without an end are drawn: nearly to the picture's edge.
  const reach = [0, 1, 2].map(i => far * tangent * (0.85 * aspect * Math.abs(right[i]) + 0.8 * Math.abs(above[i]) + 0.25 * Math.abs(forward[i])));
  return { line, point, reach };
}
