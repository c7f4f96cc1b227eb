"""Import of phone-bigram banks that artists drew in SmartBody."""
