//! The peripherals of the board beside the core: UART, timer and watchdog of ARM's Cortex-M System Design Kit.
//!
//! Source: ARM DDI 0479, sections 4.1 (timer), 4.3 (UART) and chapter 4 ("APB watchdog"); addresses from ARM DAI 0386.

use core::ptr;

/// The registers of one peripheral.
#[derive(Debug, Clone, Copy)]
struct Block {
    base: usize,
}

impl Block {
    fn read(self, offset: usize) -> u32 {
        // SAFETY: the constructors below give the base of a peripheral of this device, the constants its word registers.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance(self.base + offset)) }
    }

    fn write(self, offset: usize, value: u32) {
        // SAFETY: as in `read`.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(self.base + offset), value) }
    }
}

/// An APB UART.
#[derive(Debug, Clone, Copy)]
pub struct UartRegisters(Block);

impl UartRegisters {
    /// UART0.
    pub const UART0: Self = Self(Block { base: 0x4000_4000 });
    /// UART1.
    pub const UART1: Self = Self(Block { base: 0x4000_5000 });

    const DATA: usize = 0x0;
    const STATE: usize = 0x4;
    const CTRL: usize = 0x8;
    const INTCLEAR: usize = 0xC;
    const BAUDDIV: usize = 0x10;

    const STATE_TRANSMIT_FULL: u32 = 1 << 0;
    const STATE_RECEIVE_FULL: u32 = 1 << 1;
    const STATE_RECEIVE_OVERRUN: u32 = 1 << 3;
    /// Transmit and receive enable, transmit and receive interrupt enable.
    const CTRL_ALL: u32 = 0b1111;
    const INT_BOTH: u32 = 0b11;
    /// The least that the UART accepts. The emulated line has no bit time.
    const FASTEST: u32 = 16;

    /// Switches both directions and their interrupts on.
    pub fn enable(self) {
        self.0.write(Self::BAUDDIV, Self::FASTEST);
        self.0.write(Self::CTRL, Self::CTRL_ALL);
    }

    /// A byte has been received.
    pub fn has_byte(self) -> bool {
        self.0.read(Self::STATE) & Self::STATE_RECEIVE_FULL != 0
    }

    /// Takes the received byte.
    pub fn take_byte(self) -> u8 {
        // the upper bits of the data register read as zero
        self.0.read(Self::DATA) as u8
    }

    /// A byte can be sent.
    pub fn has_room(self) -> bool {
        self.0.read(Self::STATE) & Self::STATE_TRANSMIT_FULL == 0
    }

    /// Sends a byte.
    pub fn put_byte(self, byte: u8) {
        self.0.write(Self::DATA, u32::from(byte));
    }

    /// A byte was lost since the last call.
    pub fn take_overrun(self) -> bool {
        let overrun = self.0.read(Self::STATE) & Self::STATE_RECEIVE_OVERRUN != 0;
        if overrun {
            self.0.write(Self::STATE, Self::STATE_RECEIVE_OVERRUN);
        }
        overrun
    }

    /// Clears the flags of both interrupts.
    pub fn clear_interrupts(self) {
        self.0.write(Self::INTCLEAR, Self::INT_BOTH);
    }
}

/// An APB timer: counts down at the core clock.
#[derive(Debug, Clone, Copy)]
pub struct TimerRegisters(Block);

impl TimerRegisters {
    /// TIMER0.
    pub const TIMER0: Self = Self(Block { base: 0x4000_0000 });

    const CTRL: usize = 0x0;
    const VALUE: usize = 0x4;
    const RELOAD: usize = 0x8;
    const CTRL_ENABLE: u32 = 1;

    /// Lets it count all 32 bits round and round.
    pub fn run_freely(self) {
        self.0.write(Self::RELOAD, u32::MAX);
        self.0.write(Self::VALUE, u32::MAX);
        self.0.write(Self::CTRL, Self::CTRL_ENABLE);
    }

    /// The count, which falls.
    pub fn value(self) -> u32 {
        self.0.read(Self::VALUE)
    }
}

/// The APB watchdog: counts down, interrupts at zero, and resets the board at the second zero in a row.
#[derive(Debug, Clone, Copy)]
pub struct WatchdogRegisters(Block);

impl WatchdogRegisters {
    /// The only one.
    pub const WATCHDOG: Self = Self(Block { base: 0x4000_8000 });

    const LOAD: usize = 0x0;
    const CONTROL: usize = 0x8;
    const INTCLEAR: usize = 0xC;
    const LOCK: usize = 0xC00;
    const CONTROL_INTERRUPT_AND_RESET: u32 = 0b11;
    /// Opens the other registers for writing.
    const KEY: u32 = 0x1ACC_E551;

    /// Starts it with this many counts to zero.
    pub fn start(self, counts: u32) {
        self.0.write(Self::LOCK, Self::KEY);
        self.0.write(Self::LOAD, counts);
        self.0.write(Self::CONTROL, Self::CONTROL_INTERRUPT_AND_RESET);
    }

    /// Lets it count from the start again.
    pub fn restart(self) {
        // any value: clearing the interrupt loads the counter
        self.0.write(Self::INTCLEAR, 1);
    }
}
