let last = 0;

/** One order for the steps of both histories. */
export function nextOrder() {
  last += 1;
  return last;
}
