import { h } from './dom.ts';

/** What the page can say of advice for the command line: the sentences without commands, and those with them. */
export function splitCommands(text: string): { page: string; commands: string } {
  const sentences = text.split(/(?<=[.!?])\s+/);
  const isCommand = (sentence: string) => /`mimesh\b/.test(sentence);
  return {
    page: sentences.filter((sentence) => !isCommand(sentence)).join(' '),
    commands: sentences.filter(isCommand).join(' '),
  };
}

/** Doc comments as elements: paragraphs, and code between backticks. The rest of Markdown stays as it is written. */
export function prose(text: string): HTMLElement[] {
  return text
    .split(/\n\s*\n/)
    .map((paragraph) => paragraph.replace(/\s*\n\s*/g, ' ').trim())
    .filter((paragraph) => paragraph !== '')
    .map((paragraph) => h('p', {}, ...inline(paragraph)));
}

/** A text with the code that stands between backticks. */
export function inline(text: string): (Node | string)[] {
  return text
    .split(/(`[^`]+`)/)
    .map((piece) => (piece.startsWith('`') && piece.length > 2 ? h('code', {}, piece.slice(1, -1)) : piece));
}
