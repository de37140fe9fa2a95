//! What must hold for any bytes that claim to be a bundle or a fleet file. The fuzz targets call these with bytes of their own
//! making, and `make test` with the committed seeds and everything that was ever found.

use provision::{Bundle, Fleet, Part, authority_validity, overlay, sealed_bytes};

/// The plain form of a bundle is read or refused in words; what is read is written again as it was, and names no path.
pub(crate) fn bundle(data: &[u8]) {
    match sealed_bytes(data) {
        Ok(bytes) => assert!(bytes <= provision::MAX_BUNDLE_BYTES),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    match Bundle::unpack(data) {
        Ok(bundle) => {
            let again = bundle.pack().expect("it was packed");
            assert_eq!(Bundle::unpack(&again), Ok(bundle.clone()));
            let files: usize = Part::ALL.iter().filter_map(|part| bundle.file(*part)).map(<[u8]>::len).sum();
            assert!(files <= data.len(), "nothing grows");
            assert!(bundle.manifest.files.iter().all(|item| !item.name.contains('/')));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A fleet file is read or refused in words with lines of the file; what is read makes an overlay without surprises.
pub(crate) fn fleet(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    authority_validity(text);
    match Fleet::read(text) {
        Ok(fleet) => {
            for vessel in &fleet.vessels {
                assert!(fleet.vpn.network.has_host(vessel.vpn_address));
                let overlay = overlay(&fleet, vessel, "lutra.token", None);
                assert_eq!(overlay.matches("[Require ").count(), 1, "{overlay}");
            }
        }
        Err(problems) => {
            let lines = text.bytes().filter(|byte| *byte == b'\n').count() + 1;
            assert!(
                !problems.is_empty() && problems.iter().all(|problem| (1..=lines).contains(&problem.line))
            );
        }
    }
}
