// Numbers as people read them.

const PREFIXES: readonly (readonly [number, string])[] = [
  [1e9, "G"],
  [1e6, "M"],
  [1e3, "k"],
  [1, ""],
  [1e-3, "m"],
  [1e-6, "µ"],
];
/** Units that are read as they are. */
const PLAIN = ["kg", "m/s", "s"];

/** Four digits of a mass, three of all else, and a unit with its prefix. */
export function quantity(value: number, unit: string): string {
  if (Number.isNaN(value)) return "unknown";
  if (!Number.isFinite(value)) return "infinite";
  if (PLAIN.includes(unit)) return `${digits(value, unit === "kg" ? 4 : 3)} ${unit}`;
  const [factor, prefix] = PREFIXES.find(([least]) => Math.abs(value) >= least * 0.9995) ?? [1, ""];
  return `${digits(value / factor, 3)} ${prefix}${unit}`;
}

/** So many of something: "1 body", "2 bodies". */
export function counted(count: number, one: string, several = `${one}s`): string {
  return `${count} ${count === 1 ? one : several}`;
}

function digits(value: number, count: number): string {
  if (Math.abs(value) < 5e-7) return "0";
  if (Math.abs(value) >= 10 ** count) return String(Math.round(value));
  return String(Number(value.toPrecision(count)));
}
