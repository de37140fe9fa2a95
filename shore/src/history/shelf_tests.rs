use super::*;
use research::SightingsBuilder;

const DAY_US: i64 = 86_400_000_000;
const NO_REST: u32 = 0;

fn stretch(at: i64) -> TimeRange {
    TimeRange { from_us: at * 30 * DAY_US, to_us: (at + 1) * 30 * DAY_US }
}

fn wanted(stretches: &[i64], vessels: &[u16]) -> Wanted {
    Wanted {
        stretches: stretches.iter().map(|at| (stretch(*at), 1)).collect(),
        vessels: vessels.iter().copied().collect(),
    }
}

/// A listening report, with a weight of one.
fn piece(count: usize) -> Arc<Sightings> {
    let mut piece = SightingsBuilder::default();
    let reported = units::UtcTime::from_micros(0);
    for _ in 0..count {
        let origin = detections::Origin { system: imc::Address(1), entity: 1, reported, received: None };
        piece.listen(origin, detections::Listening::default());
    }
    Arc::new(piece.finish())
}

/// Reads the missing data of a query from stretches of so many pages, each with one report of each vessel.
fn read(shelf: &mut Shelf, wanted: &Wanted, asked: u64, pages: usize) {
    let now = Instant::now();
    for _ in 0..10 {
        let unread = shelf.unread(wanted, asked, now);
        if unread.is_empty() {
            return;
        }
        for one in unread {
            if !read_stretch(shelf, one, asked, pages) {
                break;
            }
        }
    }
    panic!("it is read again without end");
}

fn read_stretch(shelf: &mut Shelf, unread: Unread, asked: u64, pages: usize) -> bool {
    let now = Instant::now();
    let mut reading = shelf.begin(unread, asked, now);
    let mut page = 0;
    loop {
        page += 1;
        let whole_us = (page < pages).then(|| reading.stretch().to_us - page as i64 * DAY_US);
        let pieces = reading.vessels().map(|vessel| (vessel, piece(1))).collect();
        match shelf.take(&mut reading, pieces, whole_us, now) {
            Kept::All if whole_us.is_none() => return true,
            Kept::All => {}
            Kept::Again => page = 0,
            Kept::NoRoom => return false,
        }
    }
}

fn ask(shelf: &mut Shelf, wanted: &Wanted, pages: usize) -> (usize, Option<i64>) {
    let asked = shelf.ask(wanted);
    read(shelf, wanted, asked, pages);
    let found = shelf.found(wanted);
    assert_eq!(found.read_from_us, None);
    assert!(shelf.stretches.values().map(Stretch::weight).sum::<usize>() <= shelf.most);
    (found.pieces.len(), found.left_out_before_us)
}

#[test]
fn a_question_wants_the_days_that_it_asks_for_and_those_that_lie_beside() {
    let november = TimeRange { from_us: 1_793_491_200_000_000, to_us: 1_796_083_200_000_000 };
    let december = TimeRange { from_us: november.to_us, to_us: november.to_us + 31 * DAY_US };
    let of = |range: TimeRange| {
        let months = [(november, november, 1), (december, december, 2)];
        Wanted::new(months.into_iter(), range, [1].into()).stretches
    };
    let all = of(TimeRange { from_us: 0, to_us: i64::MAX });
    assert_eq!(all.len(), 16);
    assert_eq!(all[0], (TimeRange { from_us: december.from_us + 28 * DAY_US, to_us: december.to_us }, 2));
    for pair in all.windows(2) {
        assert_eq!(pair[0].0.from_us, pair[1].0.to_us, "without gaps, the newest first");
    }
    assert_eq!(all[15].0.from_us, november.from_us);
    // Days before and after the month's data are not requested.
    let heard = TimeRange { from_us: december.from_us + 5 * DAY_US, to_us: december.from_us + 6 * DAY_US };
    let few = Wanted::new([(december, heard, 2)].into_iter(), december, [1].into()).stretches;
    assert_eq!(
        few,
        [(TimeRange { from_us: december.from_us + 4 * DAY_US, to_us: december.from_us + 8 * DAY_US }, 2)]
    );
    let some = of(TimeRange { from_us: november.from_us + 5 * DAY_US, to_us: november.from_us + 8 * DAY_US });
    assert_eq!(
        some,
        [(TimeRange { from_us: november.from_us + 4 * DAY_US, to_us: november.from_us + 8 * DAY_US }, 1)]
    );
}

/// A month's stretches cover it without gaps, however long it is: data without a plausible time span decades.
#[test]
fn stretches_reach_to_the_end_of_what_they_are_of() {
    for days in [28, 29, 30, 31, 10_957] {
        let month = TimeRange { from_us: 0, to_us: days * DAY_US };
        let all: Vec<TimeRange> = stretches(month).collect();
        assert_eq!((all[0].to_us, all[all.len() - 1].from_us), (month.to_us, 0), "{days} days");
        assert!(all.windows(2).all(|pair| pair[0].from_us == pair[1].to_us), "{days} days");
    }
    let far = TimeRange { from_us: 4_102_444_800_000_000, to_us: i64::MAX };
    assert_eq!(stretches(far).next().map(|last| last.to_us), Some(i64::MAX));
}

/// A month is read again at the earliest after ten times its total reading time, and a short one after no more than that.
#[test]
fn a_month_rests_as_long_as_all_of_it_takes() {
    let mut shelf = Shelf::new(100, 10);
    // Two stretches of January 1970, and one of February.
    let of = |day: i64| TimeRange { from_us: day * DAY_US, to_us: (day + 4) * DAY_US };
    let all = |version: u64| Wanted {
        stretches: [of(31), of(4), of(0)].map(|one| (one, version)).into(),
        vessels: [1, 2].into(),
    };
    let begun = Instant::now();
    let at = |seconds: u64| begun + Duration::from_secs(seconds);
    let asked = shelf.ask(&all(1));
    for (one, took_s) in shelf.unread(&all(1), asked, begun).into_iter().zip([3, 1, 2]) {
        let mut reading = shelf.begin(one, asked, begun);
        assert_eq!(shelf.take(&mut reading, BTreeMap::new(), None, at(took_s)), Kept::All);
    }
    let unread = |seconds: u64| -> Vec<i64> {
        let unread = shelf.unread(&all(2), asked, at(seconds));
        unread.iter().map(|one| one.stretch.from_us / DAY_US).collect()
    };
    assert_eq!(unread(30), [0_i64; 0]);
    assert_eq!(unread(31), [4], "after ten times the 3 s of January, from 1 s on");
    assert_eq!(unread(32), [4, 0]);
    assert_eq!(unread(33), [31, 4, 0], "after ten times the 3 s of February, from 3 s on");
}

#[test]
fn a_question_that_is_asked_again_gets_the_same() {
    let mut shelf = Shelf::new(7, NO_REST);
    let all = wanted(&[2, 1, 0], &[1]);
    let first = ask(&mut shelf, &all, 5);
    assert_eq!(first, (7, Some(stretch(1).to_us - 2 * DAY_US)));
    for _ in 0..3 {
        assert_eq!(ask(&mut shelf, &all, 5), first);
    }
    assert_eq!(ask(&mut shelf, &wanted(&[0], &[1]), 5), (5, None), "others make room");
    assert_eq!(ask(&mut shelf, &all, 5), first, "and back");
}

#[test]
fn the_newest_stretch_takes_room_from_the_older_ones_of_the_question() {
    let mut shelf = Shelf::new(7, NO_REST);
    let mut all = wanted(&[1, 0], &[1]);
    assert_eq!(ask(&mut shelf, &all, 3), (6, None));
    // The newest one got new data.
    all.stretches[0].1 = 2;
    assert_eq!(ask(&mut shelf, &all, 6), (7, Some(stretch(0).to_us - DAY_US)));
}

#[test]
fn a_cut_stretch_is_no_shorter_when_it_is_read_again() {
    let mut shelf = Shelf::new(7, NO_REST);
    let mut one = wanted(&[0], &[1]);
    let cut = (7, Some(stretch(0).to_us - 7 * DAY_US));
    assert_eq!(ask(&mut shelf, &one, 10), cut);
    one.stretches[0].1 = 2;
    assert_eq!(ask(&mut shelf, &one, 11), cut);
}

#[test]
fn vessels_of_a_question_reach_back_equally_far() {
    let mut shelf = Shelf::new(6, NO_REST);
    assert_eq!(ask(&mut shelf, &wanted(&[0], &[1]), 5), (5, None));
    // The first alone leaves room for one page of the second.
    let both = wanted(&[0], &[1, 2]);
    assert_eq!(ask(&mut shelf, &both, 5), (6, Some(stretch(0).to_us - 3 * DAY_US)));
    assert_eq!(ask(&mut shelf, &both, 5), (6, Some(stretch(0).to_us - 3 * DAY_US)));
    assert_eq!(ask(&mut shelf, &wanted(&[0], &[2]), 5), (5, None));
}

#[test]
fn questions_without_room_together_do_not_push_each_other_out_without_end() {
    let (mut shelf, now) = (Shelf::new(5, u32::MAX), Instant::now());
    let (one, other) = (wanted(&[0], &[1]), wanted(&[0], &[2]));
    let asked = shelf.ask(&one);
    let mut reading = shelf.begin(shelf.unread(&one, asked, now).remove(0), asked, now);
    // Meanwhile the other query, which is newer, has a stretch there.
    let newer = shelf.ask(&other);
    shelf.stretches.insert(
        (0, 2),
        Stretch {
            version: 1,
            pieces: vec![piece(3)],
            reach: Reach::Whole,
            asked: newer,
            read_for: newer,
            read: None,
        },
    );
    let at = |shelf: &mut Shelf, reading: &mut Reading, page: i64, later_s: u64| {
        let pieces = BTreeMap::from([(1, piece(1))]);
        let whole_us = Some(stretch(0).to_us - page * DAY_US);
        shelf.take(reading, pieces, whole_us, now + Duration::from_secs(later_s))
    };
    assert_eq!([1, 2].map(|page| at(&mut shelf, &mut reading, page, 0)), [Kept::All; 2]);
    assert_eq!(at(&mut shelf, &mut reading, 3, 1), Kept::NoRoom);
    let again = shelf.ask(&one);
    assert_eq!(shelf.unread(&one, again, now + Duration::from_secs(2)), [], "the other was asked since");
    assert_eq!(shelf.found(&one).left_out_before_us, Some(stretch(0).to_us - 2 * DAY_US));
}

#[test]
fn who_asks_again_while_it_is_read_gets_no_less() {
    let mut shelf = Shelf::new(20, NO_REST);
    assert_eq!(ask(&mut shelf, &wanted(&[0], &[1]), 15), (15, None));
    let all = wanted(&[1, 0], &[1]);
    let asked = shelf.ask(&all);
    let now = Instant::now();
    let newest = shelf.unread(&all, asked, now).remove(0);
    let mut reading = shelf.begin(newest, asked, now);
    for page in 1..=18 {
        let whole_us = (page < 18).then(|| reading.stretch().to_us - page * DAY_US);
        let kept = shelf.take(&mut reading, BTreeMap::from([(1, piece(1))]), whole_us, now);
        assert!(matches!(kept, Kept::All), "page {page}");
        if page == 3 {
            shelf.ask(&all);
        }
    }
    let found = shelf.found(&all);
    assert_eq!(found.pieces.len(), 18, "the newest stretch is whole");
}
