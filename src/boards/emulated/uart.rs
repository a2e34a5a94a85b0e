//! The two serial lines of the board, interrupt-driven both ways.
//!
//! The interrupt handler owns the inner ends of both queues, the main loop the outer ends, so that neither ever waits
//! for the other.
//!
//! A full receive queue leaves the byte in the UART; the emulator then holds the sender back, and nothing is lost. A
//! full transmit queue means that nobody reads: the whole message is dropped and counted, since half a line would
//! spoil the next one and waiting would stop the board.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::NVIC;
use heapless::spsc::{Consumer, Producer, Queue};

use super::cmsdk::UartRegisters;
use super::interrupt::Interrupt;

/// Bytes that wait for the main loop: 10 ms of the fastest sender that the emulator serves (45 kB/s).
const RECEIVE_CAPACITY: usize = 512;

/// Bytes that wait for the client: forty frames.
pub const FORTY_FRAMES: usize = 1024;
/// Nothing is ever sent: the smallest queue that there is.
pub const NOTHING: usize = 2;

/// Bytes that one interrupt sends. Each costs the emulator a system call, and other interrupts wait.
const BYTES_AN_INTERRUPT: usize = 16;

/// Storage of one line's queues, with room for `SENT` bytes to send; lives as long as the board.
pub struct Queues<const SENT: usize> {
    receive: Queue<u8, RECEIVE_CAPACITY>,
    transmit: Queue<u8, SENT>,
}

impl<const SENT: usize> Queues<SENT> {
    /// Two empty queues.
    pub const fn new() -> Self {
        Self { receive: Queue::new(), transmit: Queue::new() }
    }
}

/// The main loop's end of a line.
pub struct Uart {
    line: &'static Line,
    received: Consumer<'static, u8>,
    to_send: Producer<'static, u8>,
    dropped: u32,
}

impl Uart {
    /// Switches the line on and its interrupts with it.
    pub fn start<const SENT: usize>(line: &'static Line, queues: &'static mut Queues<SENT>) -> Self {
        let (received_in, received) = queues.receive.split();
        let (to_send, to_send_out) = queues.transmit.split();
        free(|cs| *line.inner.borrow(cs).borrow_mut() = Some(Inner { received: received_in, to_send: to_send_out }));
        line.registers.enable();
        for interrupt in [line.receive_interrupt, line.transmit_interrupt] {
            // SAFETY: the handler's state was put in place above; no critical section relies on a mask.
            unsafe { NVIC::unmask(interrupt) };
        }
        Self { line, received, to_send, dropped: 0 }
    }

    /// The oldest byte received.
    pub fn read(&mut self) -> Option<u8> {
        let byte = self.received.dequeue();
        // Asked after the byte was taken, not before: a byte that arrives from here on finds room by itself.
        if self.line.held_back.load(Ordering::Relaxed) {
            self.line.held_back.store(false, Ordering::Relaxed);
            NVIC::pend(self.line.receive_interrupt);
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
        NVIC::pend(self.line.transmit_interrupt);
    }

    /// Messages dropped because nobody read. Wraps.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }

    /// Bytes were lost on the way in since the last call.
    pub fn take_overrun(&mut self) -> bool {
        self.line.overrun.swap(false, Ordering::Relaxed)
    }
}

/// A serial line of the board, as its interrupts see it.
pub struct Line {
    registers: UartRegisters,
    receive_interrupt: Interrupt,
    transmit_interrupt: Interrupt,
    inner: Mutex<RefCell<Option<Inner>>>,
    /// A byte was left in the UART for want of room. It will not announce itself again.
    held_back: AtomicBool,
    overrun: AtomicBool,
}

/// The interrupt handler's ends of a line's queues.
struct Inner {
    received: Producer<'static, u8>,
    to_send: Consumer<'static, u8>,
}

impl Line {
    const fn new(registers: UartRegisters, receive_interrupt: Interrupt, transmit_interrupt: Interrupt) -> Self {
        Self {
            registers,
            receive_interrupt,
            transmit_interrupt,
            inner: Mutex::new(RefCell::new(None)),
            held_back: AtomicBool::new(false),
            overrun: AtomicBool::new(false),
        }
    }

    fn on_interrupt(&self) {
        free(|cs| {
            if let Some(inner) = self.inner.borrow(cs).borrow_mut().as_mut() {
                // Cleared first: what happens from here on raises the interrupt again.
                self.registers.clear_interrupts();
                self.receive(&mut inner.received);
                self.transmit(&mut inner.to_send);
            }
        });
        if self.registers.take_overrun() {
            self.overrun.store(true, Ordering::Relaxed);
        }
    }

    fn receive(&self, received: &mut Producer<u8>) {
        while self.registers.has_byte() {
            if !received.ready() {
                self.held_back.store(true, Ordering::Relaxed);
                return;
            }
            // room was checked, and only this end fills the queue
            let _ = received.enqueue(self.registers.take_byte());
        }
    }

    fn transmit(&self, to_send: &mut Consumer<u8>) {
        for _ in 0..BYTES_AN_INTERRUPT {
            // a full UART raises the interrupt when it has sent its byte
            if !self.registers.has_room() {
                return;
            }
            let Some(byte) = to_send.dequeue() else { return };
            self.registers.put_byte(byte);
        }
        NVIC::pend(self.transmit_interrupt);
    }
}

/// UART0: the CAN bus as SLCAN.
pub static CAN_LINE: Line = Line::new(UartRegisters::UART0, Interrupt::Uart0Receive, Interrupt::Uart0Transmit);

/// UART1: the rig link.
pub static RIG_LINE: Line = Line::new(UartRegisters::UART1, Interrupt::Uart1Receive, Interrupt::Uart1Transmit);

/// Interrupts 0 and 1.
pub extern "C" fn on_uart0() {
    CAN_LINE.on_interrupt();
}

/// Interrupts 2 and 3.
pub extern "C" fn on_uart1() {
    RIG_LINE.on_interrupt();
}
