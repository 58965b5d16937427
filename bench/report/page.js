// SPDX-License-Identifier: Apache-2.0
// Script of a report page: draws the charts, connects the sliders and prepares the downloads. It loads nothing from
// outside the page.
'use strict';

// Formats 1234567 as 1.23 M, which fits the labels of an axis.
function short_number(value) {
  const steps = [[1e9, ' G'], [1e6, ' M'], [1e3, ' k']];
  for (const [size, unit] of steps)
    if (Math.abs(value) >= size) return +(value / size).toPrecision(3) + unit;
  return String(+value.toPrecision(3));
}

function draw_charts() {
  Chart.defaults.animation = false;   // so that charts are complete when the page is printed
  Chart.defaults.maintainAspectRatio = false;
  Chart.defaults.font.size = 13;
  Chart.defaults.color = '#1c2128';
  Chart.defaults.interaction.mode = 'nearest';
  Chart.defaults.interaction.axis = 'x';
  Chart.defaults.interaction.intersect = false;
  for (const data of document.querySelectorAll('script.chart-data')) {
    const config = JSON.parse(data.textContent);
    const whole = config.data.datasets.every(set => set.data.every(point => Number.isInteger(point.x)));
    config.options.scales.x.ticks = whole ? {precision: 0} : {callback: short_number};
    config.options.scales.y.ticks = {callback: short_number};
    for (const axis of Object.values(config.options.scales))
      if (axis.type === 'logarithmic') axis.ticks = {callback: value => /^[13]/.test(value.toExponential())
        ? short_number(value) : null};
    config.options.plugins.title.font = {size: 15};
    // Let the legend show lines and marks as they are drawn, and areas by their colour.
    const areas = config.options.scales.y.stacked;
    const shown = set => areas ? {} : {
      pointStyle: set.showLine ? 'line' : 'rectRot', lineDash: set.borderDash || [], lineWidth: 2};
    config.options.plugins.legend = {labels: {
      usePointStyle: !areas, pointStyleWidth: 28, boxHeight: areas ? 12 : 8,
      generateLabels: chart => Chart.defaults.plugins.legend.labels.generateLabels(chart)
        .map(label => Object.assign(label, shown(chart.data.datasets[label.datasetIndex]))),
    }};
    config.options.plugins.tooltip = {callbacks: {
      title: items => config.options.scales.x.title.text + ' ' + items[0].parsed.x,
      label: item => item.dataset.label + ': ' + +item.parsed.y.toPrecision(5),
    }};
    new Chart(document.getElementById(data.dataset.canvas), config);
  }
}

function connect_sliders() {
  for (const figure of document.querySelectorAll('figure.images')) {
    const area = figure.querySelector('.compare');
    const range = figure.querySelector('input[type=range]');
    const show = percent => {
      area.querySelector('.left').style.clipPath = `inset(0 ${100 - percent}% 0 0)`;
      area.querySelector('.handle').style.left = percent + '%';
      range.value = percent;
    };
    const follow = event => {
      const box = area.getBoundingClientRect();
      show(Math.min(100, Math.max(0, 100 * (event.clientX - box.left) / box.width)));
    };
    range.addEventListener('input', () => show(Number(range.value)));
    area.addEventListener('pointerdown', event => { area.setPointerCapture(event.pointerId); follow(event); });
    area.addEventListener('dragstart', event => event.preventDefault());   // otherwise the browser drags the image
    area.addEventListener('pointermove', event => { if (event.buttons) follow(event); });
    const box = figure.querySelector('.show-difference');
    if (box) box.addEventListener('change', () => area.classList.toggle('different', box.checked));
    show(50);
  }
}

function fill_downloads() {
  for (const data of document.querySelectorAll('script.attachment'))
    document.getElementById(data.dataset.link).href =
      URL.createObjectURL(new Blob([data.textContent.trim() + '\n'], {type: 'application/json'}));
}

draw_charts();
connect_sliders();
fill_downloads();
