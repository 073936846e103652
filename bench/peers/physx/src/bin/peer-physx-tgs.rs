//! PhysX with its other solver.

fn main() -> std::io::Result<()> {
    peer_pile::run::<peer_physx::Physx<true>>()
}
