"""Lines that pyserial opens by their URL: it looks for `protocol_NAME` here when told so (`serial.protocol_handler_packages`)."""
