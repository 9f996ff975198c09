//! The Vulkan devices of this machine.

use serde::Serialize;

/// A Vulkan device as `sorairo devices` lists it.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// The device's name.
    pub name: String,
    /// What it is made of.
    pub kind: Hardware,
    /// The driver and its version.
    pub driver: String,
}

pub(super) fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    // Validation layers cost more than an image where they are installed.
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

/// What a Vulkan device is made of, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, strum::Display)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum Hardware {
    /// A graphics card.
    Discrete,
    /// Part of the processor.
    Integrated,
    /// That of a virtual machine.
    Virtual,
    /// The driver does not say.
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

/// The Vulkan devices, best first.
pub(super) fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    adapters.sort_by_key(|adapter| Hardware::of(adapter.get_info().device_type));
    adapters
}

/// The Vulkan devices of this machine, best first.
pub fn devices() -> Vec<DeviceInfo> {
    adapters(&instance())
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            DeviceInfo {
                name: info.name,
                kind: Hardware::of(info.device_type),
                driver: format!("{} {}", info.driver, info.driver_info).trim().into(),
            }
        })
        .collect()
}
