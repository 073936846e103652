//! Energy accounting: causes of every change, and a guarantee of no gain per island.

pub(crate) mod contact_repayment;
pub(crate) mod frame_accounts;
pub(crate) mod frame_islands;
pub(crate) mod island;
pub(crate) mod island_balance;
pub(crate) mod island_correction;
pub(crate) mod islands;
pub(crate) mod ledger;
pub(crate) mod rigid_part;
