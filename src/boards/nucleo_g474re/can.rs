//! FDCAN1: classic frames at 500 kbit/s, in and out through queues, so that neither waits for the main loop.
//!
//! embassy-stm32 sets the controller up. The interrupt is served here: the driver's own handler loses frames without a
//! word when its queue is full.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU16, Ordering};

use cortex_m::interrupt::{Mutex, free};
use cortex_m::singleton;
use embassy_stm32::can::config::{GlobalFilter, NominalBitTiming, NonMatchingFilter, TxBufferMode};
use embassy_stm32::can::{Can, CanConfigurator, IT0InterruptHandler, IT1InterruptHandler};
use embassy_stm32::interrupt::Priority;
use embassy_stm32::interrupt::typelevel::{Binding, FDCAN1_IT0, Handler, Interrupt};
use embassy_stm32::peripherals::{FDCAN1, PA11, PA12};
use embassy_stm32::{Peri, bind_interrupts, pac};
use glenoid::can::health::BusHealth;
use glenoid::can::{BaseId, Frame};
use glenoid::drive_board::can_filter::{FILTERS, NO_FILTER};
use glenoid::drive_board::can_memory::{ELEMENT_WORDS, ELEMENTS, USED_WORDS, frame_of, words_of};
use glenoid::drive_board::clock::{CAN_BIT_HZ, CORE_HZ};
use glenoid::drive_board::{BitTiming, CanFilter};
use heapless::spsc::{Consumer, Producer, Queue};

/// Where the bit is sampled, thousandths of it (CiA 601-3 recommends 80 to 87.5 % at this rate).
const SAMPLE_PERMILLE: u32 = 850;

const TIMING: BitTiming = match BitTiming::new(CORE_HZ, CAN_BIT_HZ, SAMPLE_PERMILLE) {
    Ok(timing) => timing,
    Err(_) => panic!("no bit timing for this clock"),
};

/// Commands that may wait, and one: far more than the bus brings for this device while a record is stored.
type Received = Queue<Frame, 16>;
/// Frames that may wait to be sent, and one: a whole report.
type ToSend = Queue<Frame, 64>;

/// The interrupt handler's ends of the queues.
struct Ends {
    received: Producer<'static, Frame>,
    to_send: Consumer<'static, Frame>,
}

static ENDS: Mutex<RefCell<Option<Ends>>> = Mutex::new(RefCell::new(None));

/// Frames lost on the way in since it was last asked.
static LOST: AtomicU16 = AtomicU16::new(0);
/// Times that the controller has left the bus.
static BUS_OFFS: AtomicU16 = AtomicU16::new(0);

bind_interrupts!(struct Handlers {
    FDCAN1_IT0 => Mover;
    FDCAN1_IT1 => IT1InterruptHandler<FDCAN1>;
});

// SAFETY: the driver asks for its handler so that what waits for a frame is woken; nothing here ever does.
unsafe impl Binding<FDCAN1_IT0, IT0InterruptHandler<FDCAN1>> for Handlers {}

/// The controller on the bus. Dropping it would take it off.
pub struct Bus {
    _driver: Can<'static>,
    received: Consumer<'static, Frame>,
    to_send: Producer<'static, Frame>,
    dropped: u16,
}

impl Bus {
    /// Joins the bus, with the filter of a device's identifiers. None if it was called before.
    pub fn join(
        controller: Peri<'static, FDCAN1>,
        receive: Peri<'static, PA11>,
        transmit: Peri<'static, PA12>,
        base: BaseId,
    ) -> Option<Self> {
        let (producer, received) = singleton!(: Received = Queue::new())?.split();
        let (to_send, consumer) = singleton!(: ToSend = Queue::new())?.split();
        free(|cs| ENDS.borrow(cs).replace(Some(Ends { received: producer, to_send: consumer })));
        // below the sampling, which is at P0
        FDCAN1_IT0::set_priority(Priority::P8);
        let mut configurator = CanConfigurator::new(controller, receive, transmit, Handlers);
        // the driver's own filters set reserved bits
        for slot in 0..FILTERS {
            let element = if slot == 0 { CanFilter::of_block(base).element() } else { NO_FILTER };
            pac::FDCANRAM1.flssa(slot).write_value(element);
        }
        let config = configurator
            .config()
            .set_nominal_bit_timing(NominalBitTiming {
                prescaler: TIMING.prescaler,
                seg1: TIMING.segment_1,
                seg2: TIMING.segment_2,
                sync_jump_width: TIMING.jump,
            })
            .set_global_filter(GlobalFilter {
                handle_standard_frames: NonMatchingFilter::Reject,
                handle_extended_frames: NonMatchingFilter::Reject,
                reject_remote_standard_frames: true,
                reject_remote_extended_frames: true,
            })
            // by priority, two frames of one identifier could overtake each other
            .set_tx_buffer_mode(TxBufferMode::Fifo);
        configurator.set_config(config);
        Some(Self { _driver: configurator.into_normal_mode(), received, to_send, dropped: 0 })
    }

    /// The oldest frame received.
    pub fn receive(&mut self) -> Option<Frame> {
        self.received.dequeue()
    }

    /// Queues a frame. Without room, because nobody takes the frames, it is dropped and counted.
    pub fn send(&mut self, frame: Frame) {
        if self.to_send.enqueue(frame).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
        FDCAN1_IT0::pend();
    }

    /// Frames lost on the way in since the last call.
    pub fn take_lost(&mut self) -> u16 {
        LOST.swap(0, Ordering::Relaxed)
    }

    /// How the controller fares.
    pub fn health(&self) -> BusHealth {
        let errors = pac::FDCAN1.ecr().read();
        BusHealth {
            bus_off: BUS_OFFS.load(Ordering::Relaxed),
            dropped: self.dropped,
            transmit_errors: errors.tec(),
            receive_errors: errors.rec(),
            error_passive: pac::FDCAN1.psr().read().ep(),
        }
    }
}

/// Moves frames between the controller's memory and the queues.
struct Mover;

impl Handler<FDCAN1_IT0> for Mover {
    unsafe fn on_interrupt() {
        let registers = pac::FDCAN1;
        // Cleared first, by writing back what is set: what happens from here on raises the interrupt again.
        let flags = registers.ir().read();
        registers.ir().write_value(flags);
        if flags.rfl(0) {
            // the controller does not say how many
            add(&LOST, 1);
        }
        if flags.bo() {
            return_to_bus();
        }
        take_received();
        hand_over();
    }
}

/// The interrupt comes at both ends of a bus-off. The controller returns when its initialisation is ended and the bus
/// has been idle for 128 times 11 bits (RM0440, 44.3.3, "Bus-off state").
fn return_to_bus() {
    let registers = pac::FDCAN1;
    if registers.psr().read().bo() {
        add(&BUS_OFFS, 1);
        registers.cccr().modify(|w| w.set_init(false));
    }
}

fn take_received() {
    let registers = pac::FDCAN1;
    for _ in 0..ELEMENTS {
        let status = registers.rxfs(0).read();
        if status.ffl() == 0 {
            return;
        }
        let element = status.fgi();
        let mut words = [0; USED_WORDS];
        for (offset, word) in words.iter_mut().enumerate() {
            *word = pac::FDCANRAM1.rxfifo0(usize::from(element) * ELEMENT_WORDS + offset).read();
        }
        registers.rxfa(0).write(|w| w.set_fai(element));
        if let Some(frame) = frame_of(&words)
            && with_ends(|ends| ends.received.enqueue(frame).ok()).is_none()
        {
            add(&LOST, 1);
        }
    }
    // what came meanwhile is taken the next time, after the sampling had its turn
    FDCAN1_IT0::pend();
}

fn hand_over() {
    let registers = pac::FDCAN1;
    for _ in 0..ELEMENTS {
        let status = registers.txfqs().read();
        if status.tfqf() {
            return;
        }
        let Some(frame) = with_ends(|ends| ends.to_send.dequeue()) else { return };
        let buffer = usize::from(status.tfqpi());
        for (offset, word) in words_of(&frame).into_iter().enumerate() {
            pac::FDCANRAM1.txbuf(buffer * ELEMENT_WORDS + offset).write_value(word);
        }
        registers.txbar().write(|w| w.set_ar(buffer, true));
    }
}

/// Holds the other interrupts back for one step of one queue, not longer: the sampling is among them.
fn with_ends<T>(step: impl FnOnce(&mut Ends) -> Option<T>) -> Option<T> {
    free(|cs| ENDS.borrow(cs).try_borrow_mut().ok()?.as_mut().and_then(step))
}

/// Only this interrupt's handler adds, and nothing that takes away can come in between.
fn add(counter: &AtomicU16, times: u16) {
    counter.store(counter.load(Ordering::Relaxed).saturating_add(times), Ordering::Relaxed);
}
