// The card with the spectrum of a direction.

import { element } from "./controls.js";
import { plot } from "./plot.js";
import { seenAlike } from "./scene.js";

const byId = (id) => document.getElementById(id);
const digits = (value) => Number(Number(value).toPrecision(4)).toString();

export class Readout {
  hide() {
    byId("spectrum").hidden = true;
  }

  /** Asks for the spectrum of `job.measured`, and that of the left sky, and shows them. */
  async measure(worker, { scene, beside, measured, effective }, text) {
    const ask = async (each) => JSON.parse(await worker.call("spectrum", text(each), measured.azimuth, measured.elevation));
    const sky = await ask(scene);
    const left = beside && (await ask(seenAlike(beside, scene)));
    const unit = effective["sun.spectrum"] === "flat" ? "sr⁻¹" : "W·m⁻²·sr⁻¹·nm⁻¹";
    byId("plot").replaceChildren(plot(sky.wavelengths_nm, sky.radiance, sky.sun, left?.radiance, unit));
    byId("spectrum-title").textContent = `Spectrum at azimuth ${measured.azimuth}°, elevation ${measured.elevation}°`;
    byId("measure-azimuth").value = measured.azimuth;
    byId("measure-elevation").value = measured.elevation;
    const rows = [
      ["Lines", `sky, solid (${unit})${left ? "; left sky, dotted" : ""}; sun, dashed, to its own largest`],
      ["XYZ", sky.xyz.map(digits).join(", ")],
      ["Chromaticity", sky.xy ? `x ${sky.xy[0].toFixed(4)}, y ${sky.xy[1].toFixed(4)}` : "none: no light"],
      ["Luminance", `${digits(sky.luminance_cd_m2)} cd·m⁻²`],
      ["Colour temperature", sky.colour_temperature_k ? `${Math.round(sky.colour_temperature_k)} K` : "none: too far from a black body"],
    ];
    if (sky.polarisation) {
      const { degree_of_polarisation: degree, angle_of_polarisation_deg: angle, wavelength_nm: nm } = sky.polarisation;
      rows.push([`Polarisation at ${nm} nm`, `${(100 * degree).toFixed(1)} %, ${angle.toFixed(1)}° from the vertical`]);
    }
    byId("figures").replaceChildren(...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
    byId("spectrum").hidden = false;
    byId("spectrum").dataset.values = JSON.stringify(sky);
    byId("say").textContent = `Spectrum at azimuth ${measured.azimuth}°, elevation ${measured.elevation}°: luminance ${digits(sky.luminance_cd_m2)} candela per square metre.`;
  }
}
