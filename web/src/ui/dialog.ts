import { h, uniqueId } from './dom.ts';
import { icon } from './icons.ts';

/** A modal dialog with a title; closes by its button, by Escape and by a click beside it. */
export function openDialog(title: string, content: Node[], wide = false): HTMLDialogElement {
  const id = uniqueId('dialog');
  const close = h(
    'button',
    { type: 'button', class: 'button plain bare', 'aria-label': 'Close', onclick: () => dialog.close() },
    icon('close'),
  );
  const dialog = h(
    'dialog',
    { class: `dialog${wide ? ' wide' : ''}`, 'aria-labelledby': id },
    h('header', { class: 'dialog-head' }, h('h2', { id }, title), close),
    h('div', { class: 'dialog-body' }, ...content),
  );
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  dialog.addEventListener('close', () => dialog.remove());
  document.body.appendChild(dialog);
  dialog.showModal();
  return dialog;
}
