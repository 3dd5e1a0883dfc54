/** The page's words for what the server and its stages call otherwise. Pure. */

/** Parts of bodies, as stages that find points by shape call them. */
const STAGE_NAMES = new Set(['limb', 'place', 'between']);
const STAGE_NAME = /\b(?:limb|place|between)\d*-\d+\b(?: mirrored(?: \d+)?\b)?/g;

/** Neither keys of the pipeline nor names of files: those stand between backticks, or beside dots and dashes. */
const MARKER = /(?<![`./\\\w-])([Mm])arker(s?)\b(?![`:/\\-]|\.\w)/g;

/** A sentence in the words of the page: pairs are called as the list calls them. */
export function readableIn(text: string): string {
  return text
    .replace(/(?<!, )\bpoint (\d+)\b/g, 'pair $1')
    .replace(/\b[Mm]arker (?=(?:limb|place|between)\d*-\d+\b)/g, '')
    .replace(MARKER, (_, first: string, many: string) => `${first === 'M' ? 'P' : 'p'}air${many}`)
    .replace(STAGE_NAME, readable);
}

/** Names that stages and the mirror give, for people: `limb2-1` is the first point of a limb. Other names are as they are. */
export function readable(name: string): string {
  const mirrored = /^(.+) mirrored(?: (\d+))?$/.exec(name);
  if (mirrored) return `${readable(mirrored[1])}, mirrored${mirrored[2] ? ` ${mirrored[2]}` : ''}`;
  const parts = /^([a-z]+?)(\d*)-(\d+)$/.exec(name);
  if (!parts || !STAGE_NAMES.has(parts[1])) return name;
  const [, part, which, point] = parts;
  return `${part.charAt(0).toUpperCase()}${part.slice(1)}${which ? ` ${which}` : ''}, point ${point}`;
}

/** Some names in one phrase: `a, b and 3 more`. */
export function listed(names: readonly string[], most = 3): string {
  const shown = names.length > most + 1 ? [...names.slice(0, most), `${names.length - most} more`] : [...names];
  const last = shown.pop() ?? '';
  return shown.length > 0 ? `${shown.join(', ')} and ${last}` : last;
}

/** `1 pair`, `2 pairs`. */
export function counted(count: number, what: string): string {
  return `${count} ${what}${count === 1 ? '' : 's'}`;
}
