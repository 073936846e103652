// Opens a figure's player under its caption; without scripts the links lead to its page.
let frame = null;
let opened = null;

for (const link of document.querySelectorAll("a.play")) {
  link.setAttribute("aria-expanded", "false");
  link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    frame?.remove();
    opened?.setAttribute("aria-expanded", "false");
    if (opened === link) return void (opened = frame = null);
    frame = document.createElement("iframe");
    frame.src = link.href;
    frame.title = link.textContent;
    frame.allowFullscreen = true;
    link.parentElement.after(frame);
    link.setAttribute("aria-expanded", "true");
    opened = link;
  });
}
