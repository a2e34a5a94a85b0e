//! The device and everything around it: procedure, bus vocabulary, record, virtual wearer, host commands, documents.

mod architecture;
mod arm;
mod arm_poses;
mod arm_posture;
mod board_lines;
mod built_machine;
mod commission;
mod documentation;
mod drive_board;
mod identify;
mod live;
mod plot;
mod power_cut;
mod procedure;
mod rehearse;
mod rig_link;
mod shoulder;
mod slcan;
mod storage;
mod study;
mod telemetry;
mod vocabulary;
mod wearer;
