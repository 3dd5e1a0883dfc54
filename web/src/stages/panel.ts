import type { Studio } from '../app/studio.ts';
import { api, describeError, sentence } from '../protocol/client.ts';
import { fill, h } from '../ui/dom.ts';
import { effect, signal } from '../ui/signal.ts';
import { assignment } from './assign.ts';
import { yamlEditor } from './editor.ts';
import { fieldElement } from './form.ts';
import type { FormHost } from './host.ts';
import { type Field, fieldsOf, type Json, type Schema, typeOf, valueAt } from './schema.ts';

/** Every stage and setting as a form, beside the text of the pipeline. Both show the same document. */
export function stagesPanel(studio: Studio): HTMLElement {
  const schema = signal<Schema | null>(null);
  const problem = signal<string | null>(null);
  const redrawn = signal(0);
  const open = new Set<string>(['transfer']);
  const form = h('div', { class: 'form' });
  let asked = false;
  effect(() => {
    if (studio.panel.value !== 'stages' || asked) return;
    asked = true;
    void load();
  });

  async function load(): Promise<void> {
    try {
      schema.value = (await api.schema()) as Schema;
    } catch (error) {
      problem.value = describeError(error).message;
    }
  }

  effect(() => {
    const root = schema.value;
    const pipeline = studio.pipeline.pipeline.value;
    void redrawn.value;
    if (problem.value) return fill(form, h('p', { class: 'problem' }, problem.value));
    if (!root || !pipeline) return fill(form, h('p', { class: 'muted' }, 'Loading …'));
    const fields = fieldsOf(root, root);
    const host: FormHost = {
      pipeline,
      open,
      set: (path, value) => {
        const change = assignment(pipeline.value as Json, path, value, (above) =>
          typeLeftOut(fields, pipeline.value as Json, above),
        );
        void studio.pipeline.set(change.path, change.value);
      },
      unset: (path) => void studio.pipeline.unset(path),
      parse,
      redraw: () => {
        redrawn.value = redrawn.peek() + 1;
      },
    };
    if (pipeline.value === null) {
      return fill(
        form,
        h('p', { class: 'problem' }, 'The text is no YAML at present. The form comes back when it is.'),
      );
    }
    keepFocus(form, () => fill(form, ...topLevel(host, fields)));
  });
  return h('div', { class: 'stages' }, form, yamlEditor(studio));
}

/** Asks the server, which reads YAML as it reads the pipeline. */
async function parse(text: string): Promise<{ value: Json } | { problem: string }> {
  try {
    const { value, problem } = await api.yaml(text);
    if (problem === null) return { value: value as Json };
    return { problem: `${sentence(problem)} Write e.g. { clip: Run, fps: 24 }, [a, b] or a text in quotes.` };
  } catch (error) {
    return { problem: describeError(error).message };
  }
}

/** Stages and mappings, then the plain settings. */
function topLevel(host: FormHost, fields: Field[]): HTMLElement[] {
  const folds = (field: Field) => ['stage', 'object', 'list'].includes(field.kind);
  const elements = (list: Field[]) => list.map((field) => fieldElement(host, field, [field.name]));
  const plain = elements(fields.filter((field) => !folds(field)));
  return [
    ...elements(fields.filter(folds)),
    h(
      'div',
      { class: 'group top' },
      h('h3', { class: 'plain-title' }, 'Files and the rest'),
      h('div', { class: 'group-body' }, ...plain),
    ),
  ];
}

/** The type that holds where a stage is left out. */
function typeLeftOut(fields: Field[], value: Json, path: (string | number)[]): string | null {
  let present: Field[] = fields;
  let field: Field | undefined;
  for (const [depth, step] of path.entries()) {
    field = field?.kind === 'list' ? field.item() : present.find((one) => one.name === step);
    if (field?.kind === 'object') present = field.fields();
    else if (field?.kind === 'stage') {
      const type = typeOf(valueAt(value, path.slice(0, depth + 1))) ?? typeOf(field.default);
      present = field.types.find((one) => one.name === type)?.fields() ?? [];
    } else present = [];
  }
  return field?.kind === 'stage' ? typeOf(field.default) : null;
}

/** Draws anew what is in an element, with the focus and the scroll where they were. */
function keepFocus(element: HTMLElement, draw: () => void): void {
  const active = document.activeElement;
  const path = active instanceof HTMLElement && element.contains(active) ? active.dataset.path : undefined;
  const { scrollTop } = element;
  draw();
  element.scrollTop = scrollTop;
  if (path) element.querySelector<HTMLElement>(`[data-path="${CSS.escape(path)}"]`)?.focus({ preventScroll: true });
}
