use host_tests::rehearse::*; use host_tests::wearer::Wearer; use glenoid::rig::*; use glenoid::device::Config; use clap::Parser;
fn main(){
 let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).unwrap();
 let o = Options::parse();
 let mut w = Wearer::new(rig, o.wearer());
 let mut b = InProcess::new(Config::for_rig(Rig::shoulder(ASSUMED_BASE_RADIUS_MM as f32).unwrap()));
 let r = rehearse(&mut b, &mut w, &rig, &o, &Display::Silent, None);
 println!("{r}");
}
