//! The two serial lines of the board: CMSDK APB UARTs, interrupt-driven both ways.
//!
//! Source: ARM DDI 0479, "Cortex-M System Design Kit", section 4.3 (register map). The interrupt handler owns the
//! inner ends of both queues, the main loop the outer ends, so that neither ever waits for the other.
//!
//! A full receive queue leaves the byte in the UART; the emulator then holds the sender back, and nothing is lost. A
//! full transmit queue means that nobody reads: the whole message is dropped and counted, since half a line would
//! spoil the next one and waiting would stop the board.

use core::cell::RefCell;
use core::ptr;

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::NVIC;
use heapless::spsc::{Consumer, Producer, Queue};

use super::vectors::Interrupt;

/// Bytes that wait for the main loop: 25 ms of the fastest sender that the emulator serves (20 kB/s).
pub const RECEIVE_CAPACITY: usize = 512;

/// Bytes that wait for the client: forty frames.
pub const TRANSMIT_CAPACITY: usize = 1024;

/// Storage of one line's queues; lives as long as the board.
pub struct Queues {
    receive: Queue<u8, RECEIVE_CAPACITY>,
    transmit: Queue<u8, TRANSMIT_CAPACITY>,
}

impl Queues {
    /// Two empty queues.
    pub const fn new() -> Self {
        Self { receive: Queue::new(), transmit: Queue::new() }
    }
}

/// Which of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// UART0: the CAN bus as SLCAN.
    Can,
    /// UART1: the rig link.
    Rig,
}

impl Line {
    const fn registers(self) -> Registers {
        Registers {
            base: match self {
                Line::Can => 0x4000_4000,
                Line::Rig => 0x4000_5000,
            },
        }
    }

    const fn interrupts(self) -> [Interrupt; 2] {
        match self {
            Line::Can => [Interrupt::Uart0Receive, Interrupt::Uart0Transmit],
            Line::Rig => [Interrupt::Uart1Receive, Interrupt::Uart1Transmit],
        }
    }

    const fn handler(self) -> &'static Handler {
        match self {
            Line::Can => &UART0,
            Line::Rig => &UART1,
        }
    }
}

/// The main loop's end of a line.
pub struct Uart {
    line: Line,
    received: Consumer<'static, u8>,
    to_send: Producer<'static, u8>,
    dropped: u32,
}

impl Uart {
    /// Switches the line on and its interrupts with it.
    pub fn start(line: Line, queues: &'static mut Queues) -> Self {
        let (received_in, received) = queues.receive.split();
        let (to_send, to_send_out) = queues.transmit.split();
        let registers = line.registers();
        let inner = Inner { registers, received: received_in, to_send: to_send_out, overrun: false };
        free(|cs| *line.handler().borrow(cs).borrow_mut() = Some(inner));
        registers.enable();
        for interrupt in line.interrupts() {
            // SAFETY: the handler's state was put in place above; no critical section relies on a mask.
            unsafe { NVIC::unmask(interrupt) };
        }
        Self { line, received, to_send, dropped: 0 }
    }

    /// The oldest byte received.
    pub fn read(&mut self) -> Option<u8> {
        let was_full = self.received.len() == self.received.capacity();
        let byte = self.received.dequeue();
        if was_full {
            // a byte may have been left in the UART, and it will not announce itself again
            let [receive, _] = self.line.interrupts();
            NVIC::pend(receive);
        }
        byte
    }

    /// Bytes wait to be read.
    pub fn has_received(&self) -> bool {
        self.received.ready()
    }

    /// Queues a whole message. Without room for it, it is dropped whole and counted.
    pub fn write(&mut self, message: &[u8]) {
        if self.to_send.capacity() - self.to_send.len() < message.len() {
            self.dropped = self.dropped.wrapping_add(1);
            return;
        }
        for &byte in message {
            // the room was there, and only this end fills the queue
            let _ = self.to_send.enqueue(byte);
        }
        let [_, transmit] = self.line.interrupts();
        NVIC::pend(transmit);
    }

    /// Messages dropped because nobody read. Wraps.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Bytes were lost on the way in since the last call.
    pub fn take_overrun(&mut self) -> bool {
        free(|cs| {
            let mut inner = self.line.handler().borrow(cs).borrow_mut();
            inner.as_mut().is_some_and(|inner| core::mem::take(&mut inner.overrun))
        })
    }
}

/// The interrupt handler's end of a line.
struct Inner {
    registers: Registers,
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
    overrun: bool,
}

impl Inner {
    fn serve(&mut self) {
        // Cleared first: what happens from here on raises the interrupt again.
        self.registers.clear_interrupts();
        while self.received.ready() && self.registers.has_byte() {
            // room was checked, and only this end fills the queue
            let _ = self.received.enqueue(self.registers.take_byte());
        }
        while self.registers.has_room() {
            let Some(byte) = self.to_send.dequeue() else { break };
            self.registers.put_byte(byte);
        }
        self.overrun |= self.registers.take_overrun();
    }
}

type Handler = Mutex<RefCell<Option<Inner>>>;

static UART0: Handler = Mutex::new(RefCell::new(None));
static UART1: Handler = Mutex::new(RefCell::new(None));

fn serve(handler: &Handler) {
    free(|cs| {
        if let Some(inner) = handler.borrow(cs).borrow_mut().as_mut() {
            inner.serve();
        }
    });
}

/// Interrupts 0 and 1.
pub extern "C" fn on_uart0() {
    serve(&UART0);
}

/// Interrupts 2 and 3.
pub extern "C" fn on_uart1() {
    serve(&UART1);
}

/// The registers of one CMSDK APB UART (DDI 0479, table 4-5).
#[derive(Debug, Clone, Copy)]
struct Registers {
    base: usize,
}

impl Registers {
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

    fn enable(self) {
        self.write(Self::BAUDDIV, Self::FASTEST);
        self.write(Self::CTRL, Self::CTRL_ALL);
    }

    fn has_byte(self) -> bool {
        self.read(Self::STATE) & Self::STATE_RECEIVE_FULL != 0
    }

    fn take_byte(self) -> u8 {
        // the upper bits of the data register read as zero
        self.read(Self::DATA) as u8
    }

    fn has_room(self) -> bool {
        self.read(Self::STATE) & Self::STATE_TRANSMIT_FULL == 0
    }

    fn put_byte(self, byte: u8) {
        self.write(Self::DATA, u32::from(byte));
    }

    fn take_overrun(self) -> bool {
        let overrun = self.read(Self::STATE) & Self::STATE_RECEIVE_OVERRUN != 0;
        if overrun {
            self.write(Self::STATE, Self::STATE_RECEIVE_OVERRUN);
        }
        overrun
    }

    fn clear_interrupts(self) {
        self.write(Self::INTCLEAR, Self::INT_BOTH);
    }

    fn read(self, offset: usize) -> u32 {
        // SAFETY: `Line::registers` gives the base of a UART of this device, the constants above its word registers.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance(self.base + offset)) }
    }

    fn write(self, offset: usize, value: u32) {
        // SAFETY: as in `read`.
        unsafe { ptr::write_volatile(ptr::with_exposed_provenance_mut(self.base + offset), value) }
    }
}
