
// --- the notebook's widget: `model` is the state that it shares with the kernel

function render({ model, el }) {
  const frame = document.createElement("div"), root = document.createElement("div");
  frame.className = "motes-frame";
  root.className = "embedded";
  root.dataset.lmSuppressShortcuts = "true";  // disables JupyterLab's own keys
  frame.append(root);
  el.append(frame);
  const view = new View(root, order => model.send(order), { embedded: true });
  const tell = () => view.heard(model.get("state"));
  const keep = () => { if (model.get("last").byteLength) view.pictured(model.get("last")); };
  const hear = (message, buffers) => message.picture ? view.pictured(buffers[0]) : view.heard(message);
  model.on("change:state", tell);
  model.on("msg:custom", hear);
  tell();
  keep();  // the last picture of a saved notebook
  model.send({ looks: true });
  return () => {
    model.off("change:state", tell);
    model.off("msg:custom", hear);
    view.close();
  };
}

export default { render };
