use super::*;

fn read(flash: &mut MockFlash, from: u32, len: usize) -> Result<Vec<u8>, FlashError> {
    let mut bytes = vec![0; len];
    flash.read(from, &mut bytes).map(|()| bytes)
}

#[test]
fn it_writes_words_once_and_erases_pages() {
    let mut flash = MockFlash::new(2, TornWord::Zeros, 1);
    flash.write(8, &[1, 2, 3, 4, 5, 6, 7, 8]).unwrap();
    assert_eq!(read(&mut flash, 7, 10).unwrap(), [0xFF, 1, 2, 3, 4, 5, 6, 7, 8, 0xFF]);
    assert_eq!(flash.write(8, &[0; 8]), Err(FlashError::NotErased));
    assert_eq!(flash.write(4, &[0; 8]), Err(FlashError::Arguments(NorFlashErrorKind::NotAligned)));
    assert_eq!(flash.erase(0, 8), Err(FlashError::Arguments(NorFlashErrorKind::NotAligned)));
    assert_eq!(flash.erase(4096, 6144), Err(FlashError::Arguments(NorFlashErrorKind::OutOfBounds)));
    flash.erase(0, 2048).unwrap();
    assert_eq!(read(&mut flash, 8, 8).unwrap(), [0xFF; 8]);
    assert_eq!(flash.operations(), 2);
}

#[test]
fn after_the_cut_there_is_no_power() {
    let mut flash = MockFlash::new(1, TornWord::Zeros, 1);
    flash.cut_after(1);
    assert_eq!(flash.write(0, &[0x55; 24]), Err(FlashError::NoPower));
    assert!(flash.is_off());
    assert_eq!(read(&mut flash, 0, 8), Err(FlashError::NoPower));
    assert_eq!(flash.erase(0, 2048), Err(FlashError::NoPower));
    flash.power_up();
    assert_eq!(read(&mut flash, 0, 8).unwrap(), [0x55; 8], "the word before the cut is whole");
    assert_eq!(read(&mut flash, 16, 8).unwrap(), [0xFF; 8], "the word after the cut is untouched");
}

/// Each model of a torn word does what it says, and is not always the same.
#[test]
fn torn_words_read_as_their_model_says() {
    let torn = |model| {
        (0..200)
            .map(|seed| {
                let mut flash = MockFlash::new(1, model, seed);
                flash.cut_after(0);
                assert_eq!(flash.write(0, &[0x0F; 8]), Err(FlashError::NoPower));
                flash.power_up();
                [(); 8].map(|()| read(&mut flash, 0, 8).ok())
            })
            .filter(|readings| !matches!(&readings[0], Some(bytes) if *bytes == [0xFF; 8] || *bytes == [0x0F; 8]))
            .collect::<Vec<_>>()
    };
    let steady = |readings: &[Option<Vec<u8>>; 8]| readings.iter().all(|reading| *reading == readings[0]);
    let partial = torn(TornWord::PartialBits);
    assert!(partial.len() > 100 && partial.iter().all(steady));
    // bits go from 1 to 0 in writing, never elsewhere
    assert!(partial.iter().all(|[first, ..]| first.as_ref().unwrap().iter().all(|byte| byte & 0x0F == 0x0F)));
    assert!(partial.iter().any(|readings| readings[0] != partial[0][0]));
    assert!(torn(TornWord::Zeros).iter().all(|readings| steady(readings) && readings[0] == Some(vec![0; 8])));
    assert!(torn(TornWord::Error).iter().all(|readings| readings.iter().all(Option::is_none)));
    let unsteady = torn(TornWord::Unsteady);
    assert!(unsteady.iter().filter(|readings| !steady(readings)).count() > 100);
}

#[test]
fn an_erase_cut_short_disturbs_words_here_and_there() {
    let mut halves = 0;
    for seed in 0..100 {
        let mut flash = MockFlash::new(2, TornWord::Zeros, seed);
        flash.write(0, &[0x55; 4096]).unwrap();
        flash.cut_after(0);
        assert_eq!(flash.erase(0, 2048), Err(FlashError::NoPower));
        flash.power_up();
        assert_eq!(read(&mut flash, 2048, 2048).unwrap(), [0x55; 2048], "the other page is untouched");
        let page = read(&mut flash, 0, 2048).unwrap();
        let disturbed = page.chunks(8).filter(|word| **word != [0x55; 8]).count();
        halves += usize::from((64..192).contains(&disturbed));
    }
    assert!(halves > 40, "{halves}");
}

#[test]
fn defects_show() {
    let mut flash = MockFlash::new(3, TornWord::Zeros, 1);
    flash.spoil(0, Defect::Protected);
    flash.spoil(1, Defect::NotErasing);
    flash.spoil(2, Defect::NotWriting);
    assert_eq!(flash.erase(0, 2048), Err(FlashError::Protected));
    assert_eq!(flash.write(0, &[0; 8]), Err(FlashError::Protected));
    flash.erase(2048, 4096).unwrap();
    assert_eq!(read(&mut flash, 2048, 8).unwrap()[0], 0xFE);
    flash.write(4096, &[0; 8]).unwrap();
    assert_eq!(read(&mut flash, 4096, 8).unwrap()[0], 1);
}
