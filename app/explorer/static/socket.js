// The page's end of the wire: gives explorer.js the `model` that a notebook would give it.
import explorer from "./explorer.js";

const AGAIN_MS = 1000;

class Model {
  constructor() {
    this.listeners = new Map();
    this.values = new Map([["link", decoded(location.hash.slice(1))]]);
    this.connect();
  }

  connect() {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    address.hash = "";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.emit("open");
    this.socket.onmessage = (event) => this.emit("msg:custom", ...unframed(event.data));
    this.socket.onclose = () => {
      this.emit("lost");
      setTimeout(() => this.connect(), AGAIN_MS);
    };
  }

  send(content) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(content));
  }

  on(event, listener) {
    this.listeners.set(event, [...(this.listeners.get(event) ?? []), listener]);
  }

  off(event, listener) {
    this.listeners.set(event, (this.listeners.get(event) ?? []).filter((own) => own !== listener));
  }

  emit(event, ...values) {
    for (const listener of this.listeners.get(event) ?? []) listener(...values);
  }

  get(name) {
    return this.values.get(name);
  }

  set(name, value) {
    this.values.set(name, value);
    if (name === "link") {
      history.replaceState(null, "", value ? "#" + encodeURIComponent(value) : location.pathname);
    }
  }

  save_changes() {}
}

// An address may have been cut anywhere; Python tells what it makes of that.
function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

function unframed(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  const [content, sizes] = JSON.parse(text);
  let at = 4 + length;
  const buffers = sizes.map((size) => {
    at += size;
    return new DataView(bytes, at - size, size);
  });
  return [content, buffers];
}

explorer.render({ model: new Model(), el: document.getElementById("explorer") });
