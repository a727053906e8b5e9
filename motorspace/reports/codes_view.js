// Draws every figure of class codes-view with plotly, once it comes into sight.
(() => {
  const units = ["world units", "world units", "radians"];
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const scale = (data, component) => ({
    "marker.color": [data.moved[component]],
    "marker.cmin": data.scales[component].low,
    "marker.cmax": data.scales[component].high,
    "marker.colorscale": [data.scales[component].stops],
    "marker.colorbar.title.text": units[component],
    "marker.colorbar.tickvals": [data.scales[component].ticks],
    "marker.colorbar.ticktext": [data.scales[component].names],
  });

  const axis = (name) => ({
    title: { text: name, font: { size: 12, color: ink("--muted") } },
    showticklabels: false, showspikes: false, zeroline: false,
    showbackground: true, backgroundcolor: ink("--pane"), gridcolor: ink("--line"),
  });

  // Equal units on all axes, with a diagonal of much the same length for thick and thin clouds.
  const proportions = (data) => {
    const extents = data.points.map((column) => Math.max(...column) - Math.min(...column));
    const sides = extents.map((extent) => Math.max(0.15, extent / Math.max(...extents)));
    const [x, y, z] = sides.map((side) => side * 1.55 / Math.hypot(...sides));
    return { x, y, z };
  };

  const layout = (data, far) => ({
    margin: { l: 0, r: 0, t: 0, b: 0 },
    paper_bgcolor: "rgba(0,0,0,0)",
    font: { family: getComputedStyle(document.body).fontFamily, color: ink("--text") },
    uirevision: "kept",
    scene: {
      xaxis: axis(data.axes[0]), yaxis: axis(data.axes[1]), zaxis: axis(data.axes[2]),
      aspectmode: "manual", aspectratio: proportions(data), dragmode: "orbit",
      camera: { eye: { x: 1.15 * far, y: 1.15 * far, z: 0.65 * far }, center: { x: 0, y: 0, z: -0.12 } },
    },
  });

  const draw = (figure) => {
    const scene = figure.querySelector(".scene");
    const data = JSON.parse(figure.querySelector("script").textContent);
    const far = Math.max(1, scene.clientHeight / scene.clientWidth);
    const buttons = [...figure.querySelectorAll("button")];
    const degrees = data.moved[2].map((turn) => (turn * 180 / Math.PI).toFixed(0));
    const cloud = {
      type: "scatter3d", mode: "markers",
      x: data.points[0], y: data.points[1], z: data.points[2],
      customdata: data.moved[0].map((value, i) => [value, data.moved[1][i], degrees[i]]),
      hovertemplate: "longitudinal %{customdata[0]}<br>lateral %{customdata[1]}"
        + "<br>orientation %{customdata[2]}°<extra></extra>",
      marker: {
        size: scene.clientWidth < 560 ? 2 : 3, opacity: 0.9, line: { width: 0 },
        color: data.moved[0], cmin: data.scales[0].low, cmax: data.scales[0].high,
        colorscale: data.scales[0].stops,
        colorbar: {
          thickness: 10, outlinewidth: 0,
          orientation: "h", len: 0.7, x: 0.5, y: 0, yanchor: "bottom",
          title: { text: units[0], side: "top", font: { size: 12 } },
          tickvals: data.scales[0].ticks, ticktext: data.scales[0].names,
          tickfont: { size: 11 },
        },
      },
    };
    const options = { responsive: true, displayModeBar: false, scrollZoom: false };
    Plotly.newPlot(scene, [cloud], layout(data, far), options);
    buttons.forEach((button) => button.addEventListener("click", () => {
      buttons.forEach((other) => other.setAttribute("aria-pressed", String(other === button)));
      Plotly.restyle(scene, scale(data, Number(button.dataset.component)));
    }));
    dark.addEventListener("change", () => Plotly.relayout(scene, {
      ...layout(data, far), "scene.camera": scene.layout.scene.camera,
    }));
  };

  const seen = new IntersectionObserver((entries) => entries.forEach((entry) => {
    if (entry.isIntersecting) {
      seen.unobserve(entry.target);
      draw(entry.target);
    }
  }), { rootMargin: "300px" });
  document.querySelectorAll(".codes-view").forEach((figure) => seen.observe(figure));
})();
