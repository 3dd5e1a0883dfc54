/** Line icons on a grid of 24, drawn with the colour of the text. */

const PATHS = {
  undo: 'M9 14 4 9l5-5M4 9h10a6 6 0 0 1 0 12h-3',
  redo: 'm15 14 5-5-5-5M20 9H10a6 6 0 0 0 0 12h3',
  play: 'M7 4v16l13-8z',
  pause: 'M8 5v14M16 5v14',
  first: 'M6 5v14M19 5 9 12l10 7z',
  previous: 'M15 5 7 12l8 7z',
  next: 'm9 5 8 7-8 7z',
  check: 'm4 12 5 6L20 6',
  close: 'M5 5l14 14M19 5 5 19',
  trash: 'M4 7h16M9 7V4h6v3M6 7l1 13h10l1-13M10 11v6M14 11v6',
  edit: 'M4 20h4L19 9l-4-4L4 16zM13 7l4 4',
  skip: 'M5 5l8 7-8 7zM18 5v14',
  mirror: 'M12 3v18M9 7 3 17h6zM15 7l6 10h-6z',
  target: 'M12 3v4M12 17v4M3 12h4M17 12h4M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8',
  plus: 'M12 5v14M5 12h14',
  search: 'M10.5 4a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13M15.5 15.5 20 20',
  eye: 'M2 12s4-7 10-7 10 7 10 7-4 7-10 7-10-7-10-7M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6',
  hidden:
    'M3 3l18 18M10 5.3A9 9 0 0 1 12 5c6 0 10 7 10 7a18 18 0 0 1-3 3.7M6 7.5A17 17 0 0 0 2 12s4 7 10 7a9 9 0 0 0 4-1',
  link: 'M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1',
  wireframe: 'M12 3 3 20h18zM12 3v17M7.5 11.5 12 20l4.5-8.5z',
  xray: 'M4 4h10v10H4zM10 10h10v10H10z',
  whole: 'M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5',
  sun: 'M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8M12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.4 1.4M17.6 17.6 19 19M5 19l1.4-1.4M17.6 6.4 19 5',
  moon: 'M20 14A8 8 0 1 1 10 4a6.5 6.5 0 0 0 10 10z',
  help: 'M9 9a3 3 0 1 1 4.5 2.6c-1 .6-1.5 1.2-1.5 2.4M12 18v.01',
  info: 'M12 11v6M12 7v.01M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18',
  folder: 'M3 6h6l2 2h10v11H3z',
  file: 'M6 3h8l5 5v13H6zM14 3v5h5',
  upload: 'M12 16V4M7 9l5-5 5 5M4 20h16',
  warning: 'M12 4 2 20h20zM12 10v5M12 17.5v.01',
  brush: 'M4 20c3 0 5-1 5-4l3 3c0 1-2 3-8 1M10 14 19 4l2 2-9 10z',
  columns: 'M3 5h18v14H3zM12 5v14',
  columns3: 'M3 5h18v14H3zM9 5v14M15 5v14',
  list: 'M8 6h12M8 12h12M8 18h12M4 6v.01M4 12v.01M4 18v.01',
  chevron: 'm9 6 6 6-6 6',
  swap: 'M4 9h15l-4-4M20 15H5l4 4',
  up: 'm6 15 6-6 6 6',
} as const;

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGSVGElement {
  const namespace = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(namespace, 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(namespace, 'path');
  path.setAttribute('d', PATHS[name]);
  svg.appendChild(path);
  return svg;
}
