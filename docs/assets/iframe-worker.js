// Lets the search of pages that are opened as files (file://) work: browsers refuse workers there.
// A frame of the page takes the worker's place. The theme would load such a script from elsewhere;
// it takes this one because of its name.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    #frame = document.createElement("iframe");
    #loaded;

    constructor(url) {
      super();
      this.#frame.hidden = true;
      document.body.append(this.#frame);
      const inside = this.#frame.contentWindow;
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      // A worker's importScripts blocks; here it gives a promise, which the theme's worker awaits.
      inside.importScripts = async (...urls) => {
        for (const each of urls) await this.#run(each);
      };
      this.#loaded = this.#run(url);
    }

    #run(url) {
      return new Promise((loaded, failed) => {
        const script = this.#frame.contentDocument.createElement("script");
        script.src = url;
        script.onload = loaded;
        script.onerror = failed;
        this.#frame.contentDocument.body.append(script);
      });
    }

    async postMessage(data) {
      await this.#loaded;
      this.#frame.contentWindow.dispatchEvent(new MessageEvent("message", { data }));
    }

    terminate() {
      this.#frame.remove();
    }
  };
}
