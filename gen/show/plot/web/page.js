// A player opens in place of its picture; without scripts its link opens it as a page.
(function () {
  document.querySelectorAll("a.play").forEach((link) => link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    const figure = link.closest("figure"), frame = document.createElement("iframe");
    frame.sandbox = "allow-scripts"; frame.src = link.href; frame.title = figure.querySelector("b").textContent;
    frame.width = "100%"; frame.height = "600"; frame.style.border = "0";
    figure.querySelector("img").style.display = "none";
    figure.className = "broad";
    figure.prepend(frame);
    link.remove();
    frame.focus();
  }));
})();
