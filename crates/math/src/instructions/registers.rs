//! Operations on eight lanes as operations on the registers that hold them.

/// Arithmetic on whole registers, of which some hold all lanes of a type.
macro_rules! arithmetic {
    ($type:ty, [$register:ty; $count:literal],
     $($method:ident $operation:ident),*; $sqrt:ident $root:ident,
     $is_above:ident |$a:ident, $b:ident| $above:expr,
     $blend:ident |$mask:ident, $yes:ident, $no:ident| $select:expr) => {
        $(
            #[inline(always)]
            fn $method(a: $type, b: $type) -> $type {
                let mut a = unsafe { transmute::<$type, [$register; $count]>(a) };
                let b = unsafe { transmute::<$type, [$register; $count]>(b) };
                for part in 0..$count {
                    a[part] = unsafe { $operation(a[part], b[part]) };
                }
                unsafe { transmute::<[$register; $count], $type>(a) }
            }
        )*

        #[inline(always)]
        fn $sqrt(a: $type) -> $type {
            let mut a = unsafe { transmute::<$type, [$register; $count]>(a) };
            for part in 0..$count {
                a[part] = unsafe { $root(a[part]) };
            }
            unsafe { transmute::<[$register; $count], $type>(a) }
        }

        #[inline(always)]
        fn $is_above(a: $type, b: $type) -> u8 {
            let a = unsafe { transmute::<$type, [$register; $count]>(a) };
            let b = unsafe { transmute::<$type, [$register; $count]>(b) };
            let mut mask = 0;
            for part in 0..$count {
                let ($a, $b) = (a[part], b[part]);
                mask |= unsafe { $above } << (part * (LANES / $count));
            }
            mask
        }

        #[inline(always)]
        fn $blend(mask: u8, yes: $type, no: $type) -> $type {
            let yes = unsafe { transmute::<$type, [$register; $count]>(yes) };
            let no = unsafe { transmute::<$type, [$register; $count]>(no) };
            let mut out = no;
            for part in 0..$count {
                let ($mask, $yes, $no) = (mask >> (part * (LANES / $count)), yes[part], no[part]);
                out[part] = unsafe { $select };
            }
            unsafe { transmute::<[$register; $count], $type>(out) }
        }
    };
}
pub(super) use arithmetic;
