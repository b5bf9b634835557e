//! Samples in their stored type.

/// A type that a sample can have.
pub trait Sample: Copy + Send + Sync + 'static {
    /// Its name for messages and `info`.
    const TYPE: SampleType;
    /// The number it stands for.
    fn to_f64(self) -> f64;
    /// Wraps samples of this type.
    fn wrap(samples: Vec<Self>) -> Samples;
}

macro_rules! sample_types {
    ($($variant:ident $type:ident $name:literal $bytes:literal,)*) => {
        /// The type of a sample.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum SampleType {
            $(#[doc = $name] $variant,)*
        }

        impl SampleType {
            /// Every type.
            pub const ALL: &[SampleType] = &[$(SampleType::$variant),*];

            /// Its name: `uint8`, `float32`, ….
            pub fn name(self) -> &'static str {
                match self { $(SampleType::$variant => $name,)* }
            }

            /// Bytes a sample.
            pub fn bytes(self) -> usize {
                match self { $(SampleType::$variant => $bytes,)* }
            }
        }

        /// Samples of one type, x fastest, then y, then z.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Samples {
            $(#[doc = $name] $variant(Vec<$type>),)*
        }

        impl Samples {
            /// Their type.
            pub fn sample_type(&self) -> SampleType {
                match self { $(Samples::$variant(_) => SampleType::$variant,)* }
            }

            /// How many there are.
            pub fn len(&self) -> usize {
                match self { $(Samples::$variant(v) => v.len(),)* }
            }

            /// True if there are none.
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }
        }

        $(impl Sample for $type {
            const TYPE: SampleType = SampleType::$variant;
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn wrap(samples: Vec<Self>) -> Samples {
                Samples::$variant(samples)
            }
        })*

        /// Runs `$body` with `$v` bound to the typed vector of a [`Samples`], whatever its type.
        #[macro_export]
        macro_rules! with_samples {
            ($samples:expr, $v:ident => $body:expr) => {
                match $samples { $($crate::Samples::$variant($v) => $body,)* }
            };
        }
    };
}

sample_types! {
    U8 u8 "uint8" 1,
    I8 i8 "int8" 1,
    U16 u16 "uint16" 2,
    I16 i16 "int16" 2,
    U32 u32 "uint32" 4,
    I32 i32 "int32" 4,
    U64 u64 "uint64" 8,
    I64 i64 "int64" 8,
    F32 f32 "float32" 4,
    F64 f64 "float64" 8,
}
