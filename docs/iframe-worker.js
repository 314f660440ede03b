// The theme searches in a Worker, which browsers refuse to a page opened from disk. There a hidden frame of the same
// page takes its place, with the same script and the same messages.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(address) {
      super();
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      this.frame.title = "search";
      this.frame.srcdoc = "<!doctype html><title>search</title>";
      this.ready = new Promise((resolve) => {
        this.frame.addEventListener("load", () => this.load(address, resolve), {once: true});
      });
      document.documentElement.append(this.frame);
    }

    load(address, resolve) {
      const scope = this.frame.contentWindow;
      scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", {data}));
      const script = scope.document.createElement("script");
      script.src = new URL(address, document.baseURI).href;
      script.addEventListener("load", () => resolve(scope), {once: true});
      scope.document.head.append(script);
    }

    postMessage(data) {
      this.ready.then((scope) => scope.dispatchEvent(new scope.MessageEvent("message", {data})));
    }

    terminate() {
      this.frame.remove();
    }
  };
}
