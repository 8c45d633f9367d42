/* What is wider than its place scrolls, by the keyboard too: it is a stop of the tab key while it
   does. Some browsers do so by themselves. */
{
  const seen = new ResizeObserver((changed) => {
    for (const { target } of changed) {
      if (target.scrollWidth > target.clientWidth) target.tabIndex = 0;
      else target.removeAttribute("tabindex");
    }
  });
  document.querySelectorAll("pre, .table-wrapper, .formula").forEach((place) => seen.observe(place));
}
