//! PhysX with the solver that is its default.

fn main() -> std::io::Result<()> {
    peer_pile::run::<peer_physx::Physx<false>>()
}
