// Marks the section that is being read in the table of contents.
(() => {
  const links = [...document.querySelectorAll("nav a")];
  const mark = (id) => links.forEach((link) => {
    const current = link.hash === `#${id}`;
    link.toggleAttribute("aria-current", current);
    if (current) link.parentElement.scrollTo({ left: link.offsetLeft - 80, behavior: "smooth" });
  });
  if (links.length) mark(links[0].hash.slice(1));
  const seen = new IntersectionObserver((entries) => {
    const entry = entries.find((one) => one.isIntersecting);
    if (entry) mark(entry.target.id);
  }, { rootMargin: "-20% 0px -70% 0px" });
  document.querySelectorAll("section").forEach((section) => seen.observe(section));
})();
