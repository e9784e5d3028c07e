// The theme searches in a worker, and browsers start none for a page opened from a file: there a hidden frame stands
// in for it, in which the worker's script finds postMessage and importScripts as it expects them.
function prepareFrame() {
  window.postMessage = (message) => parent.postMessage(message, "*");
  window.importScripts = async (...urls) => {
    for (const url of urls) {
      await new Promise((resolve) => {
        const script = document.createElement("script");
        script.src = url;
        script.onload = resolve;
        document.body.append(script);
      });
    }
  };
}

class IFrameWorker extends EventTarget {
  constructor(url) {
    super();
    this.frame = document.createElement("iframe");
    this.frame.hidden = true;
    this.frame.srcdoc = `<body><script>(${prepareFrame})()</script><script src="${url}"></script>`;
    this.loaded = new Promise((resolve) => {
      this.frame.onload = resolve;
    });
    document.body.append(this.frame);
    addEventListener("message", (event) => {
      if (event.source === this.frame.contentWindow) {
        this.dispatchEvent(new MessageEvent("message", { data: event.data }));
      }
    });
  }

  async postMessage(data) {
    await this.loaded;
    this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
  }
}

window.IFrameWorker = IFrameWorker;
if (location.protocol === "file:") window.Worker = IFrameWorker;
