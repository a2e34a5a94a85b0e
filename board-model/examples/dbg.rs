use board_model::board::Board; use board_model::image::Image; use host_tests::rehearse::Bench; use std::rc::Rc;
fn main(){
 let image = Rc::new(Image::read(std::path::Path::new("../target/thumbv7em-none-eabihf/firmware/nucleo-g474re")).unwrap());
 let mut b=Board::new(image,1);
 b.pass(30).unwrap();
 for t in [[100,-200,300,-400,500,-600],[70000,-70000,40000,-40000,33000,-33000],[0,0,0,0,0,0]] {
  b.set_counts(&t).unwrap(); b.pass(1000).unwrap(); b.pass(5).unwrap();
  let c=b.machine.chip();
  for (k,tm) in c.timers.iter().enumerate(){ println!("{k} want {} cnt {} arr {:#x} filter {}", t[k], tm.file.at(tm.file.offset("CNT")), tm.file.at(tm.file.offset("ARR")), tm.filter_ps(170_000_000)); }
  println!("masked {:?}", b.machine.state().longest_masked);
  for (s,a) in [("LATEST",1)] { let _=(s,a); }
 }
 for l in &b.log.lines { println!("{l}"); }
 for l in b.complaints() { println!("{l}"); }
}
