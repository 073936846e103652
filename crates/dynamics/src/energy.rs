//! Energy accounting: causes of every change, and a guarantee of no gain per island.

pub(crate) mod island;
pub(crate) mod islands;
pub(crate) mod ledger;
pub(crate) mod payment;
pub(crate) mod rigid_part;
pub(crate) mod take_out;
pub(crate) mod tally;
