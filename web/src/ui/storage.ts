/** Small facts in the browser's storage, which may be full, forbidden or hold what an older page wrote. */

export function readStored<T>(key: string, otherwise: T): T {
  try {
    const text = localStorage.getItem(`mimesh-${key}`);
    return text === null ? otherwise : (JSON.parse(text) as T);
  } catch {
    return otherwise;
  }
}

export function writeStored(key: string, value: unknown): void {
  try {
    localStorage.setItem(`mimesh-${key}`, JSON.stringify(value));
  } catch {
    // It lasts as long as the page.
  }
}
