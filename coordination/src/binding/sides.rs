//! The sides of a net in the hands of others.

use super::net::NetBinding;
use crate::protocol::Side;

impl<S: Side> NetBinding<S> {
    /// This party's sides, in the order given.
    #[must_use]
    pub fn sides(&self) -> &[S] {
        &self.sides
    }

    /// As [`sides`](Self::sides), to merge levels into them. Flags are set and read by the net; a side that comes back
    /// otherwise is one of the [`misfits`](Self::misfits).
    pub fn sides_mut(&mut self) -> &mut [S] {
        self.lend();
        &mut self.sides
    }

    /// The names of the protocols whose side, since somebody has had it from [`sides_mut`](Self::sides_mut) or
    /// [`side_mut`](Self::side_mut), is one of another protocol or party, or is not up to where the net has read and
    /// set flags. Nothing is proved of such a net, so it stands still until the sides fit again.
    pub fn misfits(&self) -> impl Iterator<Item = &str> {
        let lent = self.lent.then(|| self.wiring.ports.iter().zip(&self.sides));
        let misfits = { lent.into_iter().flatten() }.filter(|(port, side)| !port.fits(*side));
        misfits.map(|(port, _)| &*port.name)
    }

    /// What the sides are now they must be when they come back, if they are not out of hand already.
    fn lend(&mut self) {
        if !std::mem::replace(&mut self.lent, true) {
            for (port, side) in self.wiring.ports.iter_mut().zip(&self.sides) {
                port.lend(side);
            }
        }
    }

    /// This party's side of the protocol called `name`. Searches.
    #[must_use]
    pub fn side(&self, name: &str) -> Option<&S> {
        self.number(name).map(|number| &self.sides[number])
    }

    /// As [`sides_mut`](Self::sides_mut), of the protocol called `name`. Searches.
    pub fn side_mut(&mut self, name: &str) -> Option<&mut S> {
        self.lend();
        self.number(name).map(|number| &mut self.sides[number])
    }
}
