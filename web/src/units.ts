// Numbers as people read them.

const PREFIXES: readonly (readonly [number, string])[] = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"]];

/** Three digits and a unit with its prefix; masses stay in kilograms. */
export function quantity(value: number, unit: string): string {
  if (Number.isNaN(value)) return "unknown";
  if (!Number.isFinite(value)) return "cannot be moved";
  const size = Math.abs(value);
  if (unit === "kg" || unit === "m/s" || unit === "s") return `${plain(value)} ${unit}`;
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least * 0.9995) ?? [1, ""];
  return `${plain(value / factor)} ${prefix}${unit}`;
}

function plain(value: number): string {
  if (value === 0 || Math.abs(value) < 5e-7) return "0";
  if (Math.abs(value) >= 1000) return Math.round(value).toLocaleString("en", { useGrouping: Math.abs(value) >= 1e4 });
  return String(Number(value.toPrecision(4).slice(0, 12)) === 0 ? value.toExponential(2) : Number(value.toPrecision(Math.abs(value) < 1 ? 3 : 4)));
}
