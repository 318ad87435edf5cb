"use strict";
// The moving picture of single runs with a line over what is drawn of them over time, buttons that copy commands, and tables
// that can be sorted and filtered. Everything else on the page works without.
(() => {
  const byId = (id) => document.getElementById(id);

  // A button copies the text before it.
  const copies = (button) => {
    if (!navigator.clipboard) return;
    button.hidden = false;
    button.addEventListener("click", async () => {
      await navigator.clipboard.writeText(button.previousElementSibling.textContent);
      button.textContent = "copied";
      setTimeout(() => { button.textContent = "copy"; }, 1200);
    });
  };
  document.querySelectorAll(".copy").forEach(copies);

  // A click on a heading sorts by that column, another one the other way round. What has no number comes last.
  const key = (row, column) => {
    const text = row.cells[column].textContent.trim(), number = parseFloat(text.replace("–", ""));
    return Number.isFinite(number) ? { number } : { text };
  };
  const order = (one, other) => {
    if ("number" in one && "number" in other) return one.number - other.number;
    if ("number" in one !== "number" in other) return "number" in one ? -1 : 1;
    return one.text < other.text ? -1 : one.text > other.text ? 1 : 0;
  };
  for (const table of document.querySelectorAll(".sortable")) {
    const headings = [...table.tHead.rows[0].cells];
    for (const [column, heading] of headings.entries()) {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...heading.childNodes);
      heading.append(button);
      button.addEventListener("click", () => {
        const falling = heading.getAttribute("aria-sort") === "ascending";
        for (const other of headings) other.removeAttribute("aria-sort");
        heading.setAttribute("aria-sort", falling ? "descending" : "ascending");
        const rows = [...table.tBodies[0].rows].map((row) => [key(row, column), row]);
        rows.sort(([one], [other]) => (falling && "number" in one === "number" in other ? order(other, one) : order(one, other)));
        table.tBodies[0].append(...rows.map(([, row]) => row));
      });
    }
  }

  // Rows that do not have what is typed are not shown.
  for (const table of document.querySelectorAll(".sortable")) {
    const rows = [...table.tBodies[0].rows];
    if (rows.length < 8) continue;
    const label = document.createElement("label"), input = document.createElement("input"), count = document.createElement("output");
    label.className = "filter";
    input.type = "search";
    label.append("only rows with ", input, " ", count);
    input.addEventListener("input", () => {
      const wanted = input.value.trim().toLowerCase();
      let shown = 0;
      for (const row of rows) {
        row.hidden = !row.textContent.toLowerCase().includes(wanted);
        if (!row.hidden) shown += 1;
      }
      count.textContent = wanted ? `${shown} of ${rows.length}` : "";
    });
    (table.closest(".scroll") || table).before(label);
  }

  // A run that is pointed at in a chart is opened if it is in the page; of another one stands there how to see it.
  const data = byId("data");
  const runs = data ? JSON.parse(data.textContent) : [];
  // Two sides of one run have a name each besides the key, which is the same.
  const nameOf = ({ side, key }) => side || key;
  const kept = new Set(runs.map(nameOf));
  for (const mark of document.querySelectorAll("[data-run]")) if (kept.has(mark.dataset.run)) mark.classList.add("opens");
  for (const figures of document.querySelectorAll("[data-replay]")) {
    figures.addEventListener("click", (event) => {
      const mark = event.target.closest("[data-run]");
      if (!mark) return;
      const key = mark.dataset.run;
      if (kept.has(key)) {
        location.hash = `run=${encodeURI(key)}`;
        return;
      }
      const figure = mark.closest("figure"), said = figure.querySelector(".pointed") || document.createElement("p");
      const code = document.createElement("code"), button = document.createElement("button");
      said.className = "command pointed";
      said.setAttribute("role", "status");
      code.textContent = figures.dataset.replay.replace("{run}", () => key.replaceAll("'", "'\\''"));
      button.type = "button";
      button.textContent = "copy";
      button.hidden = true;
      said.replaceChildren(code, button);
      copies(button);
      figure.append(said);
    });
  }

  if (!data) return;
  for (const id of ["player", "choosing", "beside"]) if (byId(id)) byId(id).hidden = false;
  document.body.classList.add("ready");

  const element = (name, attributes, parent, text) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    if (parent) parent.append(made);
    return made;
  };
  const view = byId("view"), plane = byId("plane"), slider = byId("time"), following = byId("followed");
  const choice = byId("choice"), also = byId("also"), together = byId("runs").hasAttribute("data-together");
  // Which run each of its users belongs to: two may be looked at together.
  for (const each of runs) for (const user of each.users) user.times = each.times;
  let run, second = null, followed = null, time = 0, playing = false, last = 0, until = Infinity, update = () => {};

  // The place of a road user at a time, linear between the recorded ones; null before it appears.
  const placeAt = (user, at) => {
    const times = user.times;
    let after = times.findIndex((known) => known >= at);
    if (after < 0) after = times.length - 1;
    const before = Math.max(0, after - 1);
    if (user.x[after] === null) return null;
    if (user.x[before] === null || after === before) return pick(user, after);
    const part = Math.min(1, (at - times[before]) / (times[after] - times[before]));
    const mix = (values) => values[before] + part * (values[after] - values[before]);
    // Vehicles turn evenly, the short way round; people turn at once.
    const turn = ((user.h[after] - user.h[before] + 3 * Math.PI) % (2 * Math.PI)) - Math.PI;
    const h = user.kind === "vehicle" ? user.h[before] + part * turn : user.h[after];
    return { x: mix(user.x), y: mix(user.y), v: mix(user.v), h };
  };
  const pick = (user, index) => ({ x: user.x[index], y: user.y[index], v: user.v[index], h: user.h[index] });

  // The road from above. Its y axis points up, SVG's points down.
  const drawView = (view, run) => {
    view.replaceChildren();
    const road = run.road, narrow = view.clientWidth > 0 && view.clientWidth < 560;
    const people = run.users.filter((user) => user.kind === "pedestrian").flatMap((user) => user.y).filter((y) => y !== null);
    // A road that bends or has several crossings says what of it matters; another is shown about its crossing.
    const fixed = road.view ? [road.view[0], road.view[2]] : narrow ? [-21, 9] : [-42, 16];
    const [left, right] = fixed;
    const low = road.view ? road.view[1] : Math.max(road.near - 9, Math.min(road.near - 3.2, ...people.map((y) => y - 1.8)));
    const high = road.view ? road.view[3] : Math.min(road.far + 9, Math.max(road.far + 3.2, ...people.map((y) => y + 1.8)));
    const flip = (y) => low + high - y;
    const size = road.view ? (right - left) * (narrow ? 0.034 : 0.019) : narrow ? 0.95 : 1.05;
    view.setAttribute("viewBox", `${left} ${low} ${right - left} ${high - low}`);
    for (const [kind, closed, points] of road.marks) {
      const d = points.map(([x, y], index) => `${index ? "L" : "M"}${x} ${flip(y)}`).join("") + (closed ? "z" : "");
      element("path", { class: kind, d }, view);
    }
    const lamp = road.signal && element("circle", { cx: road.lamp[0], cy: flip(road.lamp[1]), r: 0.45 }, view);
    // Where vehicles stop, as their signal shows.
    const lines = road.signal ? road.stop_lines.map(([[x, y], [toX, toY]]) => element("path", { d: `M${x} ${flip(y)}L${toX} ${flip(toY)}` }, view)) : [];
    // What a vehicle that does not see everything is shown, and what not.
    const looks = run.users.filter((user) => user.shown).flatMap((user) =>
      run.users.map((other, index) => ({ user, other, index, line: other === user ? null : element("path", { class: "look" }, view) })).filter(({ line }) => line));
    const bar = element("g", {}, view);
    element("path", { d: `M${right - 11} ${low + 0.9}v.5h10v-.5`, fill: "none", stroke: "var(--muted)", "stroke-width": 0.1 }, bar);
    element("text", { x: right - 6, y: low + 1.1, "font-size": size, "text-anchor": "middle" }, bar, "10 m");
    const actors = run.users.map((user) => {
      // The colour that it has in the plots.
      const kind = `${user.kind} ${user.look || ""}`;
      const trail = element("path", { class: `trail ${kind}` }, view);
      const body = element("g", {}, view);
      const { length, width } = user;
      if (user.round) {
        element("circle", { class: kind, r: length / 2 }, body);
      } else {
        element("rect", { class: kind, x: -length / 2, y: -width / 2, width: length, height: width, rx: user.kind === "vehicle" ? 0.35 : 0.05 }, body);
      }
      if (user.kind === "vehicle") element("path", { class: "nose", d: `M${length * 0.22} ${-width * 0.36}V${width * 0.36}` }, body);
      const label = element("text", { "font-size": size, "text-anchor": "middle" }, view);
      return { user, trail, body, label };
    });
    // Where controllers are told that others are who are elsewhere; whose, if there are several.
    const perceiving = run.users.filter((user) => user.perceived);
    const ghosts = perceiving.flatMap((user, place) => run.users.filter((other) => other !== user).map((other) => {
      const group = element("g", {}, view);
      element("title", {}, group, `${other.name} as perceived by ${user.name}`);
      const body = element("g", {}, group), { length, width } = other;
      for (const kind of ["halo", `ghost ${other.kind} ${other.look || ""}`]) {
        if (other.round) element("circle", { class: kind, r: length / 2 }, body);
        else element("rect", { class: kind, x: -length / 2, y: -width / 2, width: length, height: width }, body);
      }
      const label = perceiving.length > 1 && element("text", { "font-size": 0.65 * size, "text-anchor": "middle" }, group, `for ${user.name}`);
      // One above and the next below, so that those of one person do not cover each other.
      const reach = (other.kind === "vehicle" ? other.width : Math.max(length, width)) / 2;
      return { user, other, group, body, label, beside: place % 2 ? reach + 0.65 * size : -reach - 0.15 * size };
    }));
    return () => {
      // Of two runs the one beside follows who has the same name.
      const leader = followed && run.users.find((user) => user.name === followed.name);
      const middle = leader && placeAt(leader, time);
      const [aside, down] = middle ? [middle.x - (fixed[0] + fixed[1]) / 2, flip(middle.y) - (low + high) / 2] : [0, 0];
      const [left, right, top, bottom] = [fixed[0] + aside, fixed[1] + aside, low + down, high + down];
      view.setAttribute("viewBox", `${left} ${top} ${right - left} ${high - low}`);
      bar.setAttribute("transform", `translate(${aside} ${down})`);
      for (const { user, other, index, line } of looks) {
        const [from, to] = [placeAt(user, time), placeAt(other, time)];
        line.setAttribute("visibility", from && to ? "visible" : "hidden");
        if (!from || !to) continue;
        line.setAttribute("class", isShown(user, index) ? "look" : "look hidden");
        line.setAttribute("d", `M${from.x} ${flip(from.y)}L${to.x} ${flip(to.y)}`);
      }
      if (lamp) {
        const [cycle, from, green, amber, clearance] = road.signal;
        const since = (((time - from) % cycle) + cycle) % cycle;
        lamp.setAttribute("class", since < green ? "green" : "red");
        const stops = green > 0 && since < green + clearance;
        const state = stops ? "red" : green > 0 && since >= cycle - amber ? "amber" : "green";
        for (const line of lines) line.setAttribute("class", `stop_line ${state}`);
      }
      for (const { user, trail, body, label } of actors) {
        const place = placeAt(user, time);
        for (const part of [trail, body, label]) part.setAttribute("visibility", place ? "visible" : "hidden");
        if (!place) continue;
        body.setAttribute("transform", `translate(${place.x} ${flip(place.y)}) rotate(${(-place.h * 180) / Math.PI})`);
        let path = "";
        run.times.forEach((known, index) => {
          if (known <= time && user.x[index] !== null) path += `${path ? "L" : "M"}${user.x[index]} ${flip(user.y[index])}`;
        });
        trail.setAttribute("d", path ? `${path}L${place.x} ${flip(place.y)}` : "");
        const speed = `${user.name}${user.rides ? ` (${user.rides})` : ""} ${place.v.toFixed(1)} m/s`;
        const reach = road.view ? Math.max(user.length, user.width) : user.width;
        const [above, below] = [flip(place.y) - reach / 2 - 0.38 * size, flip(place.y) + reach / 2 + 1.05 * size];
        const fits = user.kind === "vehicle" ? above > top + size : below > bottom - 0.2 * size;
        const y = Math.min(bottom - 0.3 * size, Math.max(top + size, fits ? above : below));
        // Who is outside the picture is announced at its edge.
        const beside = place.x < left || place.x > right, beyond = flip(place.y) < top || flip(place.y) > bottom;
        if (beside || beyond) {
          const from = middle ? [middle.x, middle.y] : road.middle;
          const far = Math.round(road.view || middle ? Math.hypot(place.x - from[0], place.y - from[1]) : Math.abs(place.x));
          const arrow = beside ? (place.x < left ? "◀" : "▶") : flip(place.y) > bottom ? "▼" : "▲";
          const before = beside ? place.x < left : place.x < (left + right) / 2;
          label.textContent = before ? `${arrow} ${speed}, ${far} m away` : `${speed}, ${far} m away ${arrow}`;
          const wide = size * 0.55 * label.textContent.length;
          label.setAttribute("text-anchor", before ? "start" : "end");
          label.setAttribute("x", beside ? (before ? left + 0.5 : right - 0.5)
            : before ? Math.max(left + 0.5, Math.min(place.x, right - wide)) : Math.min(right - 0.5, Math.max(place.x, left + wide)));
        } else {
          label.textContent = speed;
          const edge = size * 0.3 * speed.length;
          label.setAttribute("text-anchor", "middle");
          label.setAttribute("x", Math.min(right - edge, Math.max(left + edge, place.x)));
        }
        label.setAttribute("y", y);
      }
      for (const { user, other, group, body, label, beside } of ghosts) {
        const told = perceivedNow(run, user).find(({ who }) => who === other), place = placeAt(other, time);
        group.setAttribute("visibility", told && place ? "visible" : "hidden");
        if (!told || !place) continue;
        body.setAttribute("transform", `translate(${told.x} ${flip(told.y)}) rotate(${(-place.h * 180) / Math.PI})`);
        if (!label) continue;
        label.setAttribute("x", told.x);
        label.setAttribute("y", flip(told.y) + beside);
      }
    };
  };

  const steps = (low, high) => {
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((known) => known >= rough * 0.999);
    const list = [];
    for (let index = Math.ceil(low / step); index * step <= high; index++) list.push(+(index * step).toFixed(6));
    return list;
  };

  // The distance-distance plane with a marker for now.
  const drawPlane = () => {
    if (!plane) return () => {};
    const legend = byId("pairs");
    plane.replaceChildren();
    legend.replaceChildren();
    const points = run.pairs.flatMap((pair) => pair.points);
    if (!points.length) return () => {};
    const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
    const range = (values, low, high) => {
      const near = values.map((value) => clamp(value, low, high));
      const span = [Math.min(0, ...near), Math.max(0, ...near)];
      return span[0] === span[1] ? [span[0] - 1, span[1] + 1] : span;
    };
    const xs = range(points.map((point) => point[0]), -60, 20), ys = range(points.map((point) => point[1]), -15, 15);
    const x = (value) => 42 + ((value - xs[0]) / (xs[1] - xs[0])) * 288, y = (value) => 216 - ((value - ys[0]) / (ys[1] - ys[0])) * 178;
    element("text", { class: "title", x: 4, y: 13 }, plane, "Distances from the conflict point");
    element("text", { class: "muted", x: 4, y: 29 }, plane, "pedestrian (m)");
    element("text", { class: "muted", x: 186, y: 254, "text-anchor": "middle" }, plane, "vehicle (m)");
    for (const tick of steps(...ys)) {
      element("line", { class: "grid", x1: 42, x2: 330, y1: y(tick), y2: y(tick) }, plane);
      element("text", { x: 37, y: y(tick) + 4, "text-anchor": "end" }, plane, tick);
    }
    for (const tick of steps(...xs)) element("text", { x: x(tick), y: 231, "text-anchor": "middle" }, plane, tick);
    element("path", { class: "axis", d: "M42 38V216H330" }, plane);
    element("path", { class: "hair", d: `M42 ${y(0)}H330M${x(0)} 38V216` }, plane);
    const inner = element("svg", { x: 42, y: 38, width: 288, height: 178, viewBox: "42 38 288 178", overflow: "hidden" }, plane);
    const markers = run.pairs.filter((pair) => pair.points.length).map((pair, index) => {
      const path = pair.points.map((point, at) => `${at ? "L" : "M"}${x(point[0]).toFixed(1)} ${y(point[1]).toFixed(1)}`).join("");
      const dashes = ["none", "7 3", "2 3", "9 3 2 3", "4 2", "12 4"][index % 6];
      const line = element("path", { class: `line c${index % 6}`, d: path, "stroke-dasharray": dashes }, inner);
      if (run.pairs.length > 1) {
        const entry = document.createElement("li");
        const swatch = element("svg", { class: "chart swatch", viewBox: "0 0 28 12" }, entry);
        element("path", { class: `line c${index % 6}`, d: "M0 6H28", "stroke-dasharray": dashes }, swatch);
        element("circle", { class: `dot c${index % 6}`, cx: 14, cy: 6, r: 4 }, swatch);
        entry.append(` ${pair.pedestrian} and ${pair.vehicle}`);
        legend.append(entry);
      }
      element("title", {}, line, `${pair.pedestrian} and ${pair.vehicle}`);
      return { pair, marker: element("circle", { class: `dot c${index % 6}`, r: 5 }, inner) };
    });
    return () => {
      for (const { pair, marker } of markers) {
        // A pair's points are those of the times at which both are there, up to the end.
        const first = run.times.length - pair.points.length;
        let index = -1;
        run.times.forEach((known, at) => { if (known <= time + 1e-9) index = at - first; });
        marker.setAttribute("visibility", index < 0 ? "hidden" : "visible");
        if (index < 0) continue;
        const [here, next] = [pair.points[index], pair.points[Math.min(index + 1, pair.points.length - 1)]];
        const span = (run.times[first + index + 1] ?? run.times[first + index] + 1) - run.times[first + index];
        const part = clamp((time - run.times[first + index]) / span, 0, 1);
        marker.setAttribute("cx", x(here[0] + part * (next[0] - here[0])));
        marker.setAttribute("cy", y(here[1] + part * (next[1] - here[1])));
      }
    };
  };

  // Whether a vehicle is shown a road user (by its index), and what somebody is up to, now.
  const isShown = (user, index) => {
    const past = user.shown.filter(([at, who]) => who === index && at <= time + 1e-9);
    return past.length > 0 && past[past.length - 1][2];
  };
  // Who was elsewhere than a vehicle's controller was told at its last decision, and what it was told.
  const perceivedNow = (run, user) => {
    const past = (user.perceived || []).filter(([at]) => at <= time + 1e-9);
    if (!past.length || !placeAt(user, time)) return [];
    const [at, age, others] = past[past.length - 1];
    return others.map(([who, x, y, off, speed]) => ({ at, who: run.users[who], age, x, y, off, speed }));
  };
  const modeOf = (user) => {
    const past = (user.modes || []).filter(([at]) => at <= time + 1e-9);
    return past.length ? past[past.length - 1][1] : "";
  };

  // Everybody in words: what they are up to, how fast they are, whom a vehicle is not shown.
  const drawStates = (list, run) => {
    const items = run.users.map((user) => ({ user, item: document.createElement("li") }));
    list.replaceChildren(...items.map(({ item }) => item));
    return () => {
      for (const { user, item } of items) {
        const place = placeAt(user, time);
        item.hidden = !place;
        if (!place) continue;
        const unseen = user.shown ? run.users.filter((other, index) => other !== user && placeAt(other, time) && !isShown(user, index)) : [];
        const mode = modeOf(user), blind = unseen.length ? `, not shown: ${unseen.map((other) => other.name).join(", ")}` : "";
        const told = perceivedNow(run, user).map(({ at, who, age, off, speed }) =>
          `; perceives ${who.name} ${off.toFixed(2)} m from where they are, moving at ${speed.toFixed(1)} m/s${age ? `, ${age.toFixed(2)} s late` : ""} (decision at ${at.toFixed(2)} s)`);
        item.textContent = `${user.name}: ${mode ? `${mode}, ` : ""}${place.v.toFixed(1)} m/s${blind}${told.join("")}`;
      }
    };
  };

  // What people's models make of it now: a table for each group of quantities, a bar from zero and a number each.
  const drawMinds = (place, run) => {
    const tables = run.users.filter((user) => user.state).flatMap((user) => {
      let first = 1;
      return user.state.groups.map(([group, names, low, high]) => {
        const from = first;
        first += names.length;
        // Values that noise drives beyond their usual range, and small ones, are shown to scale.
        const known = user.state.at.filter((state) => state).flatMap((state) => state.slice(from, first));
        const least = Math.min(0, ...known), most = Math.max(0, ...known);
        const [left, right] = low < 0 && least < most ? [least, most] : [Math.min(low, least), Math.max(high, most)];
        const table = document.createElement("table"), caption = table.createCaption(), body = table.createTBody();
        const x = (value) => ((value - left) / (right - left)) * 100;
        const rows = names.map((name) => {
          const row = body.insertRow(), heading = document.createElement("th"), cell = document.createElement("td");
          heading.scope = "row";
          heading.textContent = name;
          const svg = element("svg", { viewBox: "0 0 100 10", preserveAspectRatio: "none", "aria-hidden": "true" }, cell);
          element("path", { class: "zero", d: `M${x(0)} 0V10` }, svg);
          const bar = element("rect", { class: "bar", y: 2, height: 6 }, svg);
          row.append(heading, cell);
          const number = row.insertCell();
          number.className = "n";
          return { bar, number };
        });
        return { user, group, from, x, table, caption, rows };
      });
    });
    place.replaceChildren(...tables.map(({ table }) => table));
    return () => {
      let now = -1;
      run.times.forEach((known, at) => { if (known <= time + 1e-9) now = at; });
      for (const { user, group, from, x, caption, rows } of tables) {
        const state = user.state.at[now] || null;
        const about = state && state[0] !== null ? ` (about ${run.users[state[0]].name})` : "";
        caption.textContent = `${user.name}: ${group}${state ? about : ": nothing is weighed"}`;
        rows.forEach(({ bar, number }, index) => {
          const value = state ? state[from + index] : 0, [zero, end] = [x(0), x(value)];
          bar.setAttribute("x", Math.min(zero, end));
          bar.setAttribute("width", Math.abs(end - zero));
          number.textContent = state ? value.toFixed(3) : "–";
        });
      }
    };
  };

  const drawEvents = () => {
    const list = byId("events");
    list.replaceChildren();
    const items = run.events.map(([at, who, what]) => {
      const item = document.createElement("li"), button = document.createElement("button");
      button.type = "button";
      button.textContent = `${at.toFixed(2)} s  ${who} ${what}`;
      button.addEventListener("click", () => { pause(); show(at); });
      item.append(button);
      list.append(item);
      return { at, item };
    });
    return () => {
      const past = items.filter(({ at }) => at <= time + 1e-9);
      const now = past.length ? past[past.length - 1].at : -1;
      for (const { at, item } of items) item.className = at === now ? "now" : at > time + 1e-9 ? "later" : "";
    };
  };

  // The lines over what is drawn over time, from the first time at 42 to the last at 330 of the picture's width.
  const plots = [...document.querySelectorAll(".plots")];
  const drawCursors = () => {
    const shown = plots[runs.indexOf(run)];
    if (!shown) return () => {};
    const from = +shown.dataset.from, to = +shown.dataset.to;
    const cursors = [...shown.querySelectorAll(".panel > .chart")].map((chart) => {
      let cursor = chart.querySelector(".cursor");
      if (!cursor) {
        const bottom = chart.viewBox.baseVal.height - 44;
        cursor = element("line", { class: "cursor", y1: 38, y2: bottom }, chart);
        chart.addEventListener("pointerdown", (event) => {
          const box = chart.getBoundingClientRect();
          const place = ((event.clientX - box.left) / box.width) * chart.viewBox.baseVal.width;
          pause();
          show(Math.max(from, Math.min(to, from + ((place - 42) / 288) * (to - from))));
        });
      }
      return cursor;
    });
    return () => {
      const x = 42 + (Math.max(0, Math.min(1, (time - from) / (to - from)))) * 288;
      for (const cursor of cursors) {
        cursor.setAttribute("x1", x);
        cursor.setAttribute("x2", x);
        cursor.setAttribute("visibility", time > to + 1e-9 ? "hidden" : "visible");
      }
    };
  };

  const drawWhy = () => {
    byId("sentence").textContent = run.sentence;
    view.setAttribute("aria-label", `the run from above: ${run.sentence}`);
    byId("why").replaceChildren(...run.why.map(([kind, text, at]) => {
      const item = document.createElement("li");
      item.className = kind;
      item.textContent = text;
      if (at !== null) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = `show ${at.toFixed(2)} s`;
        button.addEventListener("click", () => { pause(); show(at); });
        item.append(button);
      }
      return item;
    }));
    plots.forEach((each, index) => { each.hidden = runs[index] !== run; });
  };

  const end = () => Math.max(...[run, second].filter((one) => one).map((one) => one.times[one.times.length - 1]));
  const show = (at) => {
    time = Math.max(0, Math.min(at, end()));
    slider.value = time;
    byId("clock").value = `${time.toFixed(2)} s`;
    update();
  };
  const pause = () => { playing = false; until = Infinity; byId("play").textContent = "▶ play"; };
  const frame = (now) => {
    if (!playing) return;
    show(Math.min(until, time + ((now - last) / 1000) * byId("pace").value));
    last = now;
    if (time >= Math.min(until, end())) pause();
    else requestAnimationFrame(frame);
  };
  const redraw = () => {
    byId("second").hidden = !second;
    byId("ghosts").hidden = ![run, ...(second ? [second] : [])].some((one) => one.users.some((user) => user.perceived));
    const beside = second ? [drawView(byId("view2"), second)] : [];
    if (second) byId("sentence2").textContent = second.sentence;
    if (second) byId("view2").setAttribute("aria-label", `the run beside from above: ${second.sentence}`);
    if (together && second) beside.push(drawStates(byId("states2"), second), drawMinds(byId("minds2"), second));
    const parts = [drawView(view, run), ...beside, drawStates(byId("states"), run), drawMinds(byId("minds"), run), drawPlane(), drawEvents(), drawCursors()];
    update = () => parts.forEach((part) => part());
    update();
  };
  const choose = (index) => {
    pause();
    run = runs[index];
    if (together) second = runs[1];
    byId("command").textContent = run.command;
    followed = null;
    // One beside stays there, unless it is the one that is chosen now.
    if (second === run) second = null;
    if (choice) [choice.value, also.value] = [index, runs.indexOf(second)];
    slider.max = end();
    const names = ["nobody", ...run.users.map((user) => user.name)];
    following.replaceChildren(...names.map((name, at) => new Option(name, at)));
    drawWhy();
    redraw();
    if (run.moment !== null) return show(run.moment);
    // Begin where something happens: when the first pedestrian is there.
    const people = run.users.filter((user) => user.kind === "pedestrian");
    const first = run.times.findIndex((_, index) => people.some((user) => user.x[index] !== null));
    show(first < 0 ? 0 : run.times[first]);
  };

  if (choice) {
    choice.append(...runs.map(({ key, reason }, index) => new Option(`${key} (${reason})`, index)));
    also.append(new Option("nothing", -1), ...runs.map(({ key }, index) => new Option(key, index)));
    byId("alone").hidden = runs.length < 2;
    also.addEventListener("change", () => {
      second = runs[also.value] || null;
      if (second === run) second = null;
      also.value = runs.indexOf(second);
      slider.max = end();
      redraw();
      show(time);
    });
    choice.addEventListener("change", () => choose(+choice.value));
  }
  following.addEventListener("change", () => { followed = run.users[following.value - 1] || null; update(); });
  slider.addEventListener("input", () => { pause(); show(+slider.value); });
  const play = () => {
    playing = true;
    byId("play").textContent = "❚❚ pause";
    if (time >= end()) show(0);
    last = performance.now();
    requestAnimationFrame(frame);
  };
  byId("play").addEventListener("click", () => (playing ? pause() : play()));
  byId("back").addEventListener("click", () => { pause(); show(time - 0.1); });
  byId("forth").addEventListener("click", () => { pause(); show(time + 0.1); });
  let width = 0;
  addEventListener("resize", () => {
    if (view.clientWidth !== width) { width = view.clientWidth; redraw(); }
  });
  const follow = () => {
    const hash = location.hash;
    const index = runs.map(nameOf).findIndex((name) => hash === `#run=${name}` || hash === `#run=${encodeURI(name)}`);
    if (index < 0) return false;
    choose(index);
    byId("runs").scrollIntoView();
    return true;
  };
  addEventListener("hashchange", follow);
  if (follow()) return;
  choose(0);
  // The worst failure is shown once up to its moment, where it stays; not to whoever wants nothing to move.
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  if (still || run.moment === null || !byId("runs").classList.contains("leads")) return;
  show(Math.max(0, run.moment - 3));
  until = run.moment;
  play();
})();
