import { api, describeError } from '../protocol/client.ts';
import { h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';

/** Takes files that are dropped or chosen, uploads them one by one and hands on their paths on the server. */
export function dropArea(done: (path: string) => void): HTMLElement {
  const state = h(
    'p',
    { class: 'hint', role: 'status', 'aria-live': 'polite' },
    'GLB, OBJ, PLY, STL, FBX or YAML. They stay on this computer.',
  );
  const input = h('input', {
    type: 'file',
    multiple: true,
    class: 'visually-hidden',
    id: 'upload',
    onchange: () => void send(input.files),
  });
  const element = h(
    'section',
    { class: 'drop', 'aria-label': 'Upload' },
    icon('upload'),
    h('p', {}, 'Drop files here, or ', h('label', { for: 'upload', class: 'link-label' }, 'choose files'), '.'),
    input,
    state,
  );

  async function send(files: FileList | null | undefined): Promise<void> {
    for (const file of files ?? []) {
      try {
        const { path } = await api.upload(file, (share) => {
          state.textContent = `Reading ${file.name}: ${Math.round(share * 100)} %`;
        });
        state.textContent = `${file.name} is ready.`;
        done(path);
      } catch (error) {
        state.textContent = `${file.name}: ${describeError(error).message}`;
      }
    }
    input.value = '';
  }

  element.addEventListener('dragover', (event) => {
    event.preventDefault();
    element.classList.add('over');
  });
  element.addEventListener('dragleave', () => element.classList.remove('over'));
  element.addEventListener('drop', (event) => {
    event.preventDefault();
    element.classList.remove('over');
    void send(event.dataTransfer?.files);
  });
  return element;
}
