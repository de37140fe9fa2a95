//! The kinds of messages: which command a vessel, and which belong to an exchange that is not repeated.

use imc::PacketView;
use imc::messages::{self as m, Payload as _};

/// Whether a packet makes a vessel do something. This one definition decides what is never dropped as a copy when it
/// is sent twice, and what goes to a vessel by one way only. Answers have the same id, but are not commands.
pub(crate) fn is_command(view: &PacketView<'_>) -> bool {
    match view.id() {
        // The first field is the type; 0 is a request in all three.
        m::PlanControl::ID | m::PlanDB::ID | m::VehicleCommand::ID => view.payload().first() == Some(&0),
        id => matches!(
            id,
            m::Abort::ID
                | m::AcousticOperation::ID
                | m::AcousticRequest::ID
                | m::Calibration::ID
                | m::DevCalibrationControl::ID
                | m::EmergencyControl::ID
                | m::GpioStateSet::ID
                | m::LoggingControl::ID
                | m::OperationalLimits::ID
                | m::PlanGeneration::ID
                | m::PopEntityParameters::ID
                | m::PowerChannelControl::ID
                | m::PowerOperation::ID
                | m::PushEntityParameters::ID
                | m::Reference::ID
                | m::RemoteActions::ID
                | m::RestartSystem::ID
                | m::SaveEntityParameters::ID
                | m::SetEntityParameters::ID
                | m::SetLedBrightness::ID
                | m::SetPWM::ID
                | m::SetServoPosition::ID
                | m::SmsRequest::ID
                | m::Teleoperation::ID
                | m::TeleoperationDone::ID
                | m::TransmissionRequest::ID
        ),
    }
}

/// Whether a message belongs to an exchange between two systems: a request or an answer that is not repeated.
pub(crate) fn is_exchange(id: u16) -> bool {
    matches!(
        id,
        m::EntityInfo::ID
            | m::EntityList::ID
            | m::LoggingControl::ID
            | m::PlanSpecification::ID
            | m::PopEntityParameters::ID
            | m::PowerChannelControl::ID
            | m::PushEntityParameters::ID
            | m::QueryEntityParameters::ID
            | m::RemoteActionsRequest::ID
            | m::SaveEntityParameters::ID
            | m::SetEntityParameters::ID
    ) || id == m::PlanDB::ID
}
