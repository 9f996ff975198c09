//! The graphics devices of this machine.

use serde::Serialize;

/// A graphics device, as `sorairo devices` lists it.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// The device's name.
    pub name: String,
    /// The kind of its hardware.
    pub kind: Hardware,
    /// The driver and its version.
    pub driver: String,
    /// Its graphics interface: Vulkan, Metal or Direct3D 12.
    pub interface: &'static str,
}

/// The kind of a graphics device's hardware, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::Display)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[non_exhaustive]
pub enum Hardware {
    /// A graphics card.
    Discrete,
    /// Integrated into the CPU.
    Integrated,
    /// The device of a virtual machine.
    Virtual,
    /// Unknown to the driver.
    Other,
    /// None: software on the CPU.
    Software,
}

impl Hardware {
    fn of(device_type: wgpu::DeviceType) -> Self {
        match device_type {
            wgpu::DeviceType::DiscreteGpu => Self::Discrete,
            wgpu::DeviceType::IntegratedGpu => Self::Integrated,
            wgpu::DeviceType::VirtualGpu => Self::Virtual,
            wgpu::DeviceType::Other => Self::Other,
            wgpu::DeviceType::Cpu => Self::Software,
        }
    }
}

/// The interfaces whose devices are opened, by wgpu's names. wgpu contains only those of this platform that the
/// features select.
const INTERFACES: wgpu::Backends = wgpu::Backends::VULKAN.union(wgpu::Backends::METAL).union(wgpu::Backends::DX12);

fn interface(backend: wgpu::Backend) -> &'static str {
    match backend {
        wgpu::Backend::Metal => "Metal",
        wgpu::Backend::Dx12 => "Direct3D 12",
        _ => "Vulkan",
    }
}

/// The graphics devices, best first. A device with two interfaces is listed first by Vulkan, which accepts SPIR-V.
fn adapters() -> Vec<wgpu::Adapter> {
    // Without any, wgpu has no instance.
    if !wgpu::Instance::enabled_backend_features().intersects(INTERFACES) {
        return Vec::new();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = INTERFACES;
    // Validation layers cost more than an image where they are installed.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(INTERFACES));
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        (Hardware::of(info.device_type), info.backend != wgpu::Backend::Vulkan)
    });
    adapters
}

/// The best graphics device whose name contains `wanted`, ignoring case.
pub fn adapter(wanted: &str) -> Option<wgpu::Adapter> {
    let wanted = wanted.to_lowercase();
    adapters().into_iter().find(|adapter| adapter.get_info().name.to_lowercase().contains(&wanted))
}

/// The graphics devices of this machine, best first.
pub fn devices() -> Vec<DeviceInfo> {
    adapters()
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            DeviceInfo {
                name: info.name,
                kind: Hardware::of(info.device_type),
                driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
                interface: interface(info.backend),
            }
        })
        .collect()
}
