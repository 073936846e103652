// The player in a frame of its own, inside a notebook. Python sends chunks of a run as they are made; a gap in their
// numbers, or a notebook that is opened again, asks for those that are missing.
export default () => {
  /** All chunks so far, and who hands them on. */
  const chunks = [];
  const views = new Set();

  return {
    initialize({ model }) {
      let asked = -1;
      const ask = () => {
        if (asked === chunks.length) return;
        asked = chunks.length;
        model.send({ from: asked });
      };
      model.on("msg:custom", ({ number }, [chunk]) => {
        if (number > chunks.length) return ask();
        if (number < chunks.length) return;
        chunks.push(new Uint8Array(chunk.buffer, chunk.byteOffset, chunk.byteLength).slice());
        for (const handOn of views) handOn();
      });
      ask();
    },

    render({ model, el }) {
      const frame = document.createElement("iframe");
      // Scripts run in it, apart from the notebook.
      frame.setAttribute("sandbox", "allow-scripts");
      frame.allow = "fullscreen";
      frame.title = model.get("title");
      Object.assign(frame.style, { width: "100%", height: `${model.get("height")}px`, border: "0" });
      frame.srcdoc = model.get("page");

      // Its origin is nobody's, so that no name of it can be given.
      const post = (message) => frame.contentWindow?.postMessage(message, "*");
      let sent = Infinity;
      const handOn = () => {
        for (; sent < chunks.length; sent++) post({ chunk: chunks[sent] });
      };
      const pick = () => post({ pick: model.get("picked") });
      const hear = ({ source, data }) => {
        if (source !== frame.contentWindow) return;
        if (data === "ready") {
          sent = 0;
          handOn();
          pick();
        } else if (data?.picked === null || Number.isSafeInteger(data?.picked)) {
          model.set("picked", data.picked);
          model.save_changes();
        }
      };
      addEventListener("message", hear);
      model.on("change:picked", pick);
      views.add(handOn);
      el.append(frame);
      return () => {
        removeEventListener("message", hear);
        model.off("change:picked", pick);
        views.delete(handOn);
      };
    },
  };
};
