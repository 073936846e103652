// Pictures of buttons.

/** Paths on a square of 24. */
const PATHS: Record<string, string> = {
  play: "M7 4v16l13-8z",
  pause: "M6 4h4v16H6zM14 4h4v16h-4z",
  first: "M5 4h3v16H5zM20 4v16L9 12z",
  back: "M16 4v16L5 12zM17 4h3v16h-3z",
  forth: "M8 4v16l11-8zM4 4h3v16H4z",
  break: "M13 2 5 13h5l-2 9 9-12h-5z",
  loop:
    "M7 6h10V3l5 4.500-5 4.500V9H7v3H4V9a3 3 0 0 1 3-3zM17 18H7v3l-5-4.500L7 12v3h10v-3h3v3a3 3 " +
    "0 0 1-3 3z",
  "graph-toggle": "M3 3h2v16h16v2H3zM7 17v-5l4-4 4 3 5-6v12z",
  reset: "M12 3 2 11h3v9h5v-6h4v6h5v-9h3z",
  full: "M4 4h6v2H6v4H4zM14 4h6v6h-2V6h-4zM4 14h2v4h4v2H4zM18 14h2v6h-6v-2h4z",
  help:
    "M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20zm-1 14h2v2h-2zm4.1-5.6L14 11.500c-.7.7-1 1.300-1 " +
    "2.500h-2v-.5c0-1.100.4-2.100 1.100-2.800l1.300-1.300A2 2 0 1 0 10 8H8a4 4 0 1 1 7.100 2.400z",
  "piece-before": "M15 4v16L6 12z",
  "piece-after": "M9 4v16l9-8z",
  "piece-focus":
    "M11 2h2v3.100A7 7 0 0 1 18.900 11H22v2h-3.100A7 7 0 0 1 13 18.900V22h-2v-3.100A7 7 0 0 1 " +
    "5.100 13H2v-2h3.100A7 7 0 0 1 11 5.100zM12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8z",
  "piece-close":
    "M6.400 5 12 10.600 17.600 5 19 6.400 13.400 12l5.600 5.600-1.400 1.400-5.600-5.600L6.400 19 " +
    "5 17.600l5.600-5.600L5 6.400z",
};

/** Give a button the picture of a name. */
export function icon(button: HTMLElement, name: string): void {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", PATHS[name]!);
  svg.append(path);
  button.replaceChildren(svg);
  button.dataset["icon"] = name;
}
