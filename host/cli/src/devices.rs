//! The command that lists devices.

use sorairo::Device;

use crate::arguments::DevicesArguments;
use crate::error::Result;
use crate::output::print_line;

/// `sorairo devices`.
pub fn run(arguments: &DevicesArguments) -> Result<()> {
    let (devices, cpu) = (Device::gpus(), Device::cpu());
    if arguments.json {
        let mut list = serde_json::to_value(&devices).expect("devices are plain data");
        let cpu = serde_json::json!({ "name": cpu.name, "kind": "cpu", "driver": "", "interface": "" });
        list.as_array_mut().expect("a list of devices is an array").push(cpu);
        return print_line(&list.to_string());
    }
    for device in devices {
        print_line(&format!("{} ({}, {}, {})", device.name, device.kind, device.interface, device.driver))?;
    }
    print_line(&cpu.name)
}
