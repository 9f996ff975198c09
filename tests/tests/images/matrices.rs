//! Cameras of an engine's matrices, against those of keys.

use sorairo::glam::dcamera::{lh::proj::directx as lh, rh::proj::directx as rh};
use sorairo::glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use sorairo::scene::{CameraScene, Preset, Projection, Scene, Size};
use sorairo::{Device, Direction, PixelFormat, Plan, Sky};
use sorairo_shared::math::max;

const SIZE: Size = Size { width: 96, height: 54 };
const WIDE: f64 = 16.0 / 9.0;

fn sky() -> Sky {
    let mut scene = Scene::preset(Preset::Standard);
    (scene.sun.elevation, scene.sun.azimuth, scene.observer.altitude) = (12.0, 20.0, 3.0);
    Sky::new(&scene).unwrap()
}

/// A view of a world of which y is up, from somewhere in it.
fn view(azimuth: f64, elevation: f64, roll: f64) -> DMat4 {
    // Azimuth is clockwise from -z, and so against the turns about y; so is a clockwise roll against those about z.
    let turn = DQuat::from_rotation_y(-azimuth.to_radians())
        * DQuat::from_rotation_x(elevation.to_radians())
        * DQuat::from_rotation_z(-roll.to_radians());
    DMat4::from_rotation_translation(turn, DVec3::new(2e5, 6.4e6, -3e5)).inverse()
}

fn vertical(fov: f64) -> f64 {
    2.0 * ((fov / 2.0).to_radians().tan() / WIDE).atan()
}

fn projection(fov: f64) -> DMat4 {
    rh::perspective_infinite_reverse(vertical(fov), WIDE, 0.1)
}

fn y_up(view: DMat4, projection: DMat4, size: Size) -> CameraScene {
    CameraScene::from_matrices(view, projection, CameraScene::Y_UP, size).unwrap()
}

fn image(sky: &Sky, camera: &CameraScene) -> Vec<f32> {
    sky.image(camera, &mut Device::cpu()).unwrap().rgb
}

/// The largest difference of two images, relative to the brightest of the second.
fn worst(found: &[f32], expected: &[f32]) -> f32 {
    assert!(found.len() == expected.len() && !found.is_empty());
    let brightest = expected.iter().copied().fold(0.0, max);
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    off.fold(0.0, |worst, off| if off.is_nan() || off > worst { off } else { worst }) / brightest
}

#[test]
fn matrices_without_roll_draw_the_pixels_of_the_keys() {
    let sky = sky();
    for (azimuth, elevation, fov) in [(20.0, 5.0, 60.0), (-130.0, -30.0, 100.0), (300.0, 89.0, 20.0)] {
        let keys = CameraScene {
            projection: Projection::Perspective,
            size: SIZE,
            fov: Some(fov),
            look_azimuth: Some(azimuth),
            look_elevation: Some(elevation),
            ..CameraScene::default()
        };
        let expected = image(&sky, &keys);
        let view = view(azimuth, elevation, 0.0);
        let finite = rh::perspective(vertical(fov), WIDE, 10.0, 4e4);
        for projection in [projection(fov), finite, lh::perspective(vertical(fov), WIDE, 0.1, 9.0)] {
            // The camera of a left-handed space looks along its z.
            let view =
                if projection.col(2).w > 0.0 { DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * view } else { view };
            let camera = y_up(view, projection, SIZE);
            // Rounding of the axes in single precision, beside a horizon that is smooth in linear RGB nowhere.
            let off = worst(&image(&sky, &camera), &expected);
            assert!(off < 1e-5, "{azimuth}°, {elevation}°: {off}");
            let product =
                CameraScene::from_matrices(DMat4::IDENTITY, projection * view, CameraScene::Y_UP, SIZE).unwrap();
            assert!((product.fov.unwrap() - fov).abs() < 1e-6 && product.roll.abs() < 1e-6);
        }
    }
}

#[test]
fn a_tile_of_a_projection_is_the_tile_of_the_picture() {
    let (sky, view) = (sky(), view(15.0, -2.0, 30.0));
    let whole = image(&sky, &y_up(view, projection(75.0), SIZE));
    let quarter = Size { width: SIZE.width / 2, height: SIZE.height / 2 };
    for (left, top) in [(0, 0), (1, 0), (1, 1)] {
        // Clip space of the tile, of twice the size and with the tile's middle in its own.
        let (x, y) = (1.0 - 2.0 * f64::from(left), 2.0 * f64::from(top) - 1.0);
        let tile = DMat4::from_translation(DVec3::new(x, y, 0.0)) * DMat4::from_scale(DVec3::new(2.0, 2.0, 1.0));
        let camera = y_up(view, tile * projection(75.0), quarter);
        let found = image(&sky, &camera);
        let rows = (0..quarter.height).flat_map(|row| {
            let first = ((row + top * quarter.height) * SIZE.width + left * quarter.width) as usize;
            &whole[3 * first..3 * (first + quarter.width as usize)]
        });
        let off = worst(&found, &rows.copied().collect::<Vec<_>>());
        assert!(off < 1e-5, "{left}, {top}: {off}");
    }
}

#[test]
fn a_jitter_moves_the_picture_by_its_part_of_a_pixel() {
    let mut jittered = projection(60.0);
    // As engines do it: a third of a pixel to the right in clip space.
    jittered.z_axis.x -= 2.0 / f64::from(SIZE.width) / 3.0;
    let camera = y_up(view(0.0, 10.0, 0.0), jittered, SIZE);
    assert!((camera.shift_x * f64::from(SIZE.width) + 1.0 / 3.0).abs() < 1e-6, "{}", camera.shift_x);
    assert!(camera.shift_y.abs() < 1e-9);
}

#[test]
fn a_roll_turns_the_picture_about_its_middle() {
    let sky = sky();
    let square = Size { width: 51, height: 51 };
    let projection = rh::perspective_infinite_reverse(1.0, 1.0, 0.1);
    let [upright, rolled] = [0.0, 90.0].map(|roll| image(&sky, &y_up(view(40.0, 5.0, roll), projection, square)));
    // A camera on its right side has on top what was on the right.
    let turned = (0..51).flat_map(|row| (0..51).map(move |column| 51 * column + 50 - row));
    let expected: Vec<f32> = turned.flat_map(|at| upright[3 * at..3 * at + 3].to_vec()).collect();
    let off = worst(&rolled, &expected);
    assert!(off < 1e-5, "{off}");
    assert!(worst(&rolled, &upright) > 0.05);
}

#[test]
fn worlds_of_other_axes_have_the_same_camera() {
    let projection = projection(50.0);
    let expected = y_up(view(70.0, -25.0, 10.0), projection, SIZE);
    // From y up to z up, and to a left-handed world in which z is north.
    let z_up = DMat4::from_cols(DVec4::X, DVec4::NEG_Z, DVec4::Y, DVec4::W);
    let left_handed = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let unity = DMat3::from_cols(DVec3::NEG_Y, DVec3::Z, DVec3::X);
    for (world, axes) in [(z_up, CameraScene::Z_UP), (left_handed, unity)] {
        let camera = CameraScene::from_matrices(view(70.0, -25.0, 10.0) * world, projection, axes, SIZE).unwrap();
        for (found, expected) in [
            (camera.look_azimuth, expected.look_azimuth),
            (camera.look_elevation, expected.look_elevation),
            (Some(camera.roll), Some(expected.roll)),
        ] {
            assert!((found.unwrap() - expected.unwrap()).abs() < 1e-6);
        }
    }
    assert!((expected.roll - 10.0).abs() < 1e-6 && (expected.look_azimuth.unwrap() - 70.0).abs() < 1e-6);
}

#[test]
fn straight_up_the_roll_says_what_lies_on_the_right() {
    let plan = |roll| {
        let camera = y_up(view(0.0, 90.0, roll), projection(60.0), SIZE);
        Plan::seen(&sky(), &camera, PixelFormat::LinearRgb).unwrap()
    };
    // East is on the right and north at the bottom, which a quarter turn clockwise of the camera brings to the right.
    for (roll, azimuth) in [(0.0, 90.0), (90.0, 0.0)] {
        let right = Direction::of_pixel(&plan(roll), SIZE.width - 1, SIZE.height / 2).unwrap();
        let off = (right.azimuth - azimuth + 180.0).rem_euclid(360.0) - 180.0;
        // The pixel's centre lies half a pixel below the middle.
        assert!(off.abs() < 1.0, "{roll}: {right:?}");
    }
}

#[test]
fn what_is_no_perspective_is_refused() {
    let view = view(0.0, 0.0, 0.0);
    let refused = |view, projection, size| {
        CameraScene::from_matrices(view, projection, CameraScene::Y_UP, size).unwrap_err().to_string()
    };
    let orthographic = rh::orthographic(-1.0, 1.0, -1.0, 1.0, 0.1, 10.0);
    let mut skewed = projection(60.0);
    skewed.y_axis.x = 0.3;
    for none in [DMat4::ZERO, DMat4::NAN, orthographic, skewed] {
        assert!(refused(view, none, SIZE).starts_with("projection is no perspective"));
    }
    assert!(refused(DMat4::ZERO, projection(60.0), SIZE).contains("no perspective"));
    let down = DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * projection(60.0);
    assert!(refused(view, down, SIZE).contains("mirrors"));
    assert!(refused(view, projection(60.0), Size { width: 96, height: 96 }).contains("54.0 rows"));
}
