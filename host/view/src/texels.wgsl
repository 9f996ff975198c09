// The texels of the sky on their part of the window, which is the viewport. egui passes no SPIR-V through, and no physics is here.

@group(0) @binding(0) var sky: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
}

// One triangle that covers the viewport.
@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4<f32>(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y, 0.0, 1.0), place);
}

fn colour_at(place: vec2<f32>) -> vec4<f32> {
    return textureLoad(sky, vec2<i32>(place * vec2<f32>(textureDimensions(sky))), 0);
}

@fragment
fn texel(corner: Corner) -> @location(0) vec4<f32> {
    return colour_at(corner.place);
}

// For a window that turns linear values into sRGB by itself (IEC 61966-2-1).
@fragment
fn linear_texel(corner: Corner) -> @location(0) vec4<f32> {
    let colour = colour_at(corner.place);
    let power = pow((colour.rgb + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(power, colour.rgb / 12.92, colour.rgb <= vec3<f32>(0.04045)), 1.0);
}
