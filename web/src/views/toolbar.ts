import { display } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import { button } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { componentsButton } from './components.ts';
import type { Stage } from './stage.ts';

/** The buttons over the views that change how meshes are shown. */
export function viewToolbar(studio: Studio, stage: Stage): HTMLElement {
  return h(
    'div',
    { class: 'view-tools', role: 'toolbar', 'aria-label': 'View' },
    button({ label: 'Whole mesh', keys: 'Home', icon: 'whole', bare: true, run: () => stage.camera.whole() }),
    toggle('Wireframe', 'W', 'wireframe', display.wireframe),
    toggle('X-ray', 'X', 'xray', display.xray),
    toggle('Link cameras', 'L', 'link', display.linked),
    toggle('Target at rest in a view of its own', 'V', 'columns3', display.threeViews),
    componentsButton(studio),
  );
}

function toggle(
  label: string,
  keys: string,
  icon: 'wireframe' | 'xray' | 'link' | 'columns3',
  value: { value: boolean },
): HTMLElement {
  return button({
    label,
    keys,
    icon,
    bare: true,
    pressed: () => value.value,
    run: () => {
      value.value = !value.value;
    },
  });
}
