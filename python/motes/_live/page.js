// The page of a live run: its view, and the socket to the run.

const GROWTH = 1.6, LONGEST_PAUSE_MS = 15000;

let socket = null, ended = false, pauseMs = 400;
const view = new Desk(document.getElementById("view"), order => {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(order));
}, { keys: document });

function connect() {
  const address = new URL("live" + location.search, location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { pauseMs = 400; view.online(true); };
  socket.onmessage = ({ data }) => typeof data === "string" ? heard(JSON.parse(data)) : view.pictured(new DataView(data));
  socket.onclose = () => {
    socket = null;
    if (ended) return view.online(false);
    view.online(false, `no connection; trying again in ${Math.ceil(pauseMs / 1000)} s`);
    setTimeout(connect, pauseMs);
    pauseMs = Math.min(pauseMs * GROWTH, LONGEST_PAUSE_MS);
  };
}

function heard(said) {
  view.heard(said);
  ended ||= Boolean(said.ended);
  document.title = `${view.state.title || "motes"} - motes`;
}

view.online(false, "connecting ...");
connect();
