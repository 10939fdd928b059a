// Draws the curves of the compared designs.
"use strict";
{
  const plots = JSON.parse(document.getElementById("data").textContent);
  for (const plot of plots) charts.add(document.getElementById("plot-" + plot.id), plot, charts.show);
}
