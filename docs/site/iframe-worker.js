// Search on pages that are opened from a disk. Browsers start no worker there, so that a hidden frame
// takes its place. It offers what the theme's search uses: `postMessage`, messages and `terminate`.
// The theme would load such a script from another host; its name holds "iframe-worker" to stop that.

class FrameWorker extends EventTarget {
  /** @param {string | URL} url the script to run */
  constructor(url) {
    super();
    this.frame = document.createElement("iframe");
    this.frame.hidden = true;
    document.body.append(this.frame);
    const inner = /** @type {Window & typeof globalThis} */ (this.frame.contentWindow);
    this.heard = (/** @type {MessageEvent} */ event) => {
      if (event.source === inner) {
        this.dispatchEvent(new MessageEvent("message", { data: event.data }));
      }
    };
    addEventListener("message", this.heard);
    const scope = "window.postMessage = (data) => parent.postMessage(data, '*');";
    inner.document.open();
    inner.document.write(`<script>${scope}</script><script src="${url}"></script>`);
    inner.document.close();
    // `open` has taken all listeners away, so that this one comes after it
    this.ready = new Promise((resolve) => inner.addEventListener("load", resolve));
  }

  /** @param {unknown} data what the script hears */
  async postMessage(data) {
    await this.ready;
    this.frame.contentWindow?.dispatchEvent(new MessageEvent("message", { data }));
  }

  terminate() {
    removeEventListener("message", this.heard);
    this.frame.remove();
  }
}

if (location.protocol === "file:") {
  Object.assign(window, { Worker: FrameWorker });
}
